//! The sweeps: polygons of one kind, of which one thing goes step by step from easy to extreme.

use hyperspan::error::Error;
use hyperspan::space::Viewport;

use super::random::Random;
use super::shape::{Case, Corner, Shape, unproject, window};
use super::ties;

/// Polygons of one kind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep {
    pub(crate) name: &'static str,
    /// What a step is.
    pub(crate) parameter: &'static str,
    pub(crate) steps: &'static [f64],
    /// Polygon number `.1` of step `.0`. The numbers come from a stream that is the same at
    /// each step, so that nothing else changes.
    pub(crate) make: fn(f64, usize, &mut Random) -> Result<Case, Error>,
}

/// Frames of [`panned`] in each step.
pub(crate) const FRAMES: usize = 100;

/// All of them.
pub(crate) const SWEEPS: [Sweep; 13] = [
    Sweep {
        name: "w ratio",
        parameter: "greatest w over least",
        steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9],
        make: |ratio, _, random| {
            Ok(Shape::triangle(viewport(512, 512)?, ratio, random).case_at_extremes(random))
        },
    },
    Sweep {
        name: "width",
        parameter: "pixels, at a w ratio of 1000",
        steps: &[1.0, 2.0, 5.0, 16.0, 64.0, 256.0, 1024.0, 4096.0, 16384.0],
        make: wide,
    },
    Sweep {
        name: "magnitude",
        parameter: "attributes up to",
        steps: &[1e-30, 1e-20, 1e-10, 1.0, 1e10, 1e20, 1e30],
        make: |size, _, random| {
            let mut shape = Shape::triangle(viewport(512, 512)?, 100.0, random);
            shape.attributes.iter_mut().flatten().for_each(|value| *value *= size);
            Ok(shape.case_at_extremes(random))
        },
    },
    Sweep {
        name: "offset",
        parameter: "change of an attribute of 1",
        steps: &[1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
        make: |change, _, random| {
            let mut shape = Shape::triangle(viewport(512, 512)?, 100.0, random);
            for value in shape.attributes.iter_mut().flatten() {
                *value = 1.0 + change * *value;
            }
            Ok(shape.case_at_extremes(random))
        },
    },
    Sweep {
        name: "sliver",
        parameter: "pixels thick",
        steps: &[16.0, 1.0, 0.1, 0.01, 1e-3, 1e-4, 1.0 / 65536.0],
        make: sliver,
    },
    Sweep {
        name: "origin",
        parameter: "pixels from the framebuffer's origin",
        steps: &[0.0, 1e3, 1e5, 1e7, 1e9, 2.147e9],
        make: |distance, _, random| {
            let [x, y] = [0, 1].map(|_| random.signed(distance) as i32);
            // A side of 512 pixels still ends within i32.
            let viewport = Viewport::new(x, y, 512, 512)?;
            Ok(Shape::triangle(viewport, 100.0, random).case_at_extremes(random))
        },
    },
    Sweep {
        name: "edge-on",
        parameter: "pixels from the plane at w = 1, which goes on to w = 100",
        steps: &[100.0, 10.0, 1.0, 0.1, 0.01, 1e-3],
        make: edge_on,
    },
    Sweep {
        name: "near plane",
        parameter: "its distance; polygons reach from behind the eye to 100",
        steps: &[1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9],
        make: through_near,
    },
    Sweep {
        name: "vertices",
        parameter: "of an N-gon",
        steps: &[3.0, 4.0, 5.0, 6.0, 8.0, 12.0, 16.0, 32.0, 64.0],
        make: inscribed,
    },
    Sweep {
        name: "giant",
        parameter: "times the viewport",
        steps: &[2.0, 10.0, 50.0, 100.0, 1e3, 1e4, 1e5, 1e6],
        make: giant,
    },
    Sweep {
        name: "chain",
        parameter: "bulge of 16 edges, part of their length",
        steps: &[0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
        make: chain,
    },
    Sweep {
        name: "pan",
        parameter: "first of a hundred frames, each 0.377 pixels on",
        steps: &[0.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0, 900.0],
        make: panned,
    },
    Sweep {
        name: "tie",
        parameter: "halvings towards a value halfway between two f32",
        steps: &[0.0, 8.0, 16.0, 24.0, 32.0],
        make: ties::near_a_tie,
    },
];

fn viewport(width: u32, height: u32) -> Result<Viewport, Error> {
    Viewport::new(0, 0, width, height)
}

/// From the left end of a viewport to the right one.
fn wide(width: f64, _: usize, random: &mut Random) -> Result<Case, Error> {
    const HEIGHT: u32 = 64;
    let viewport = viewport(width as u32, HEIGHT)?;
    let mut shape = Shape::triangle(viewport, 1000.0, random);
    let hair = |random: &mut Random| random.within(-0.5, 0.5);
    shape.corners[0].at[0] = hair(random);
    shape.corners[1].at[0] = width + hair(random);
    Ok(shape.case_at_extremes(random))
}

/// A direction of small whole numbers, and a centre of a pixel: the line through it that way goes
/// through many centres, so that what is thin covers some of them.
fn line_through_centres(random: &mut Random) -> ([f64; 2], [f64; 2]) {
    let directions = [[1, 0], [0, 1], [1, 1], [1, -1], [2, 1], [-1, 3], [3, -2], [4, 1]];
    let direction = directions[random.below(directions.len())].map(f64::from);
    (direction, [0, 1].map(|_| 256.5 + random.below(200) as f64 - 100.0))
}

/// A triangle along a line through centres.
fn sliver(thickness: f64, _: usize, random: &mut Random) -> Result<Case, Error> {
    let (direction, centre) = line_through_centres(random);
    let length = (direction[0] * direction[0] + direction[1] * direction[1]).sqrt();
    let aside = [-direction[1] / length, direction[0] / length];
    let mut shape = Shape::triangle(viewport(512, 512)?, 100.0, random);
    // The line lies somewhere within the triangle at its thickest.
    let shift = random.unit();
    let mut place = |along: f64, off: f64| {
        let along = along + random.within(-0.4, 0.4);
        [0, 1]
            .map(|i| centre[i] + along * 60.0 * direction[i] + (off - shift) * thickness * aside[i])
    };
    let places = [place(-1.0, 0.0), place(1.0, 0.0), place(0.0, 1.0)];
    for (corner, at) in shape.corners.iter_mut().zip(places) {
        corner.at = at;
    }
    let windows = [-1.0, 0.0, 1.0]
        .map(|t| window(shape.viewport, [0, 1].map(|i| centre[i] + t * 50.0 * direction[i])));
    Ok(shape.case(windows.to_vec()))
}

/// A strip of a plane that goes through the eye, but for `height`: all of its picture lies within
/// so many pixels of a line through centres. With the eye at the origin the plane is
/// (x, y, w) = w centre + u direction + height aside, and crosses the line at w = 1/cut.
fn edge_on(height: f64, _: usize, random: &mut Random) -> Result<Case, Error> {
    const FAR: f64 = 100.0;
    let (direction, centre) = line_through_centres(random);
    let aside = [-direction[1], direction[0]];
    let viewport = viewport(512, 512)?;
    let cut = 1.0 / random.up_to(FAR);
    let slopes: Vec<[f64; 3]> =
        (0..2).map(|_| [0, 1, 2].map(|_| random.within(-1.0, 1.0))).collect();
    let reach = 40.0;
    let (mut positions, mut attributes) = (Vec::new(), Vec::new());
    for (along, w) in [(-1.0, 1.0), (1.0, 1.0), (1.0, FAR), (-1.0, FAR)] {
        let at = [0, 1].map(|i| {
            centre[i] + along * reach * direction[i] + height * (1.0 / w - cut) * aside[i]
        });
        // Depth as a reversed camera has it: z is the same everywhere.
        positions.push(unproject(viewport, at, 0.5 / w, w));
        let value = |[a, b, c]: &[f64; 3]| (a + (b + c * along) * w / FAR) as f32;
        attributes.push(slopes.iter().map(value).collect());
    }
    let windows = [-0.5, 0.0, 0.5]
        .map(|t| window(viewport, [0, 1].map(|i| centre[i] + t * reach * direction[i])));
    Ok(Case { viewport, positions, attributes, windows: windows.to_vec() })
}

/// A quadrilateral round a point that is seen, reaching far behind the eye and beyond: a floor or
/// a wall that one stands in. Reversed depth without a far plane.
fn through_near(near: f64, _: usize, random: &mut Random) -> Result<Case, Error> {
    const FAR: f64 = 100.0;
    let viewport = viewport(512, 512)?;
    let at = [0, 1].map(|_| random.within(8.0, 504.0));
    let distance = near * random.up_to(FAR);
    // x, y and w; z is `near` everywhere.
    let [x, y, _, w] = unproject(viewport, at, 0.0, distance);
    let mut axis = || {
        let size = distance * random.up_to(FAR / near);
        [0, 1, 2].map(|_| random.within(-1.0, 1.0) * size)
    };
    let axes = [axis(), axis()];
    let slopes: Vec<[f64; 3]> =
        (0..2).map(|_| [0, 1, 2].map(|_| random.within(-1.0, 1.0))).collect();
    let (mut positions, mut attributes) = (Vec::new(), Vec::new());
    for [s, t] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
        let off = [0, 1, 2].map(|i| s * axes[0][i] + t * axes[1][i]);
        positions.push([x + off[0], y + off[1], near, w + off[2]]);
        attributes.push(slopes.iter().map(|[a, b, c]| (a + b * s + c * t) as f32).collect());
    }
    Ok(Case { viewport, positions, attributes, windows: vec![window(viewport, at)] })
}

/// An N-gon within an ellipse.
fn inscribed(count: f64, _: usize, random: &mut Random) -> Result<Case, Error> {
    let mut shape = Shape::triangle(viewport(512, 512)?, 100.0, random);
    shape.outline = (0..count as usize)
        .map(|i| {
            let angle = (i as f64 + 0.8 * random.unit()) * std::f64::consts::TAU / count;
            let [a, b] = [0.4 * libm::cos(angle), 0.4 * libm::sin(angle)];
            // Two directions at right angles among weights whose sum stays.
            let [a, b] = [a / 2.0_f64.sqrt(), b / 6.0_f64.sqrt()];
            [1.0 / 3.0 + a + b, 1.0 / 3.0 - a + b, 1.0 / 3.0 - 2.0 * b]
        })
        .collect();
    Ok(shape.case_at_extremes(random))
}

/// A triangle all round the viewport.
fn giant(times: f64, _: usize, random: &mut Random) -> Result<Case, Error> {
    const SIDE: f64 = 512.0;
    let mut shape = Shape::triangle(viewport(512, 512)?, 100.0, random);
    let turn = random.unit();
    for (corner, third) in shape.corners.iter_mut().zip([0.0, 1.0, 2.0]) {
        let angle = (turn + (third + random.within(-0.3, 0.3)) / 3.0) * std::f64::consts::TAU;
        let reach = times * SIDE * random.within(0.5, 1.0);
        corner.at = [libm::cos(angle), libm::sin(angle)].map(|c| SIDE / 2.0 + reach * c);
    }
    let windows = [0, 1, 2].map(|_| window(shape.viewport, [0, 1].map(|_| random.unit() * SIDE)));
    Ok(shape.case(windows.to_vec()))
}

/// Sixteen edges that are nearly one, bulging away from the corner opposite.
fn chain(bulge: f64, _: usize, random: &mut Random) -> Result<Case, Error> {
    const EDGES: u32 = 16;
    let (direction, centre) = line_through_centres(random);
    let mut shape = Shape::triangle(viewport(512, 512)?, 100.0, random);
    // Beyond the edge 1/w goes on falling: it stays above 0 if the corner opposite is farthest.
    shape.corners.sort_by(|a, b| a.w.total_cmp(&b.w));
    let at = |along: f64| [0, 1].map(|i| centre[i] + along * direction[i]);
    let aside = [-direction[1], direction[0]].map(|c| c * random.signed(60.0));
    let apex = [0, 1].map(|i| centre[i] + aside[i]);
    for (corner, at) in shape.corners.iter_mut().zip([at(-48.0), at(48.0), apex]) {
        // Where it bulges, depth stays within 0..1: it is not to be bent by being clamped.
        *corner = Corner { at, depth: 0.25 + 0.5 * corner.depth, ..*corner };
    }
    shape.outline = (0..=EDGES)
        .map(|i| {
            let t = f64::from(i) / f64::from(EDGES);
            let off = 4.0 * bulge * t * (1.0 - t);
            [1.0 - t + off / 2.0, t + off / 2.0, -off]
        })
        .chain([[0.0, 0.0, 1.0]])
        .collect();
    let windows = [-40.0, 0.0, 40.0].map(|along| window(shape.viewport, at(along)));
    Ok(shape.case(windows.to_vec()))
}

/// A triangle that moves from frame to frame by a part of a pixel, and the window with it.
fn panned(first: f64, index: usize, random: &mut Random) -> Result<Case, Error> {
    const STEP: f64 = 0.377;
    let shift = STEP * (first + (index % FRAMES) as f64);
    let mut shape = Shape::triangle(viewport(512, 512)?, 1000.0, random);
    shape.viewport = viewport(1024, 512)?;
    shape.corners.iter_mut().for_each(|corner| corner.at[0] += shift);
    Ok(shape.case_at_extremes(random))
}
