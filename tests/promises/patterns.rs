//! Coverage that can be read: `#` is drawn, `.` is not. The target panics if a pixel is drawn
//! twice or lies outside.

use crate::oracle::Poly;
use crate::oracle::probe::Sheet;
use crate::oracle::shapes::unproject;
use hyperspan::shade::Solid;
use hyperspan::space::{Grid, PixelRect, Viewport};
use hyperspan::target::Plane;
use hyperspan::tiler::{Outcome, Tiler};

/// The clip positions of points in the framebuffer of a `width` x `height` picture. Whole and
/// half pixels are exact if the sides are powers of two.
fn at(width: u32, height: u32, points: &[[f64; 2]]) -> Poly {
    let viewport = Viewport::new(0, 0, width, height).expect("small");
    let place = |p: &[f64; 2]| unproject(viewport, *p, 0.5, 1.0);
    Poly::bare(&points.iter().map(place).collect::<Vec<_>>())
}

/// Draws polygons one after the other: 1 to 9 and a to z for those of the list, `.` for nothing.
fn picture(width: u32, height: u32, polygons: &[&[[f64; 2]]]) -> String {
    let mut tiler = Tiler::new(Viewport::new(0, 0, width, height).expect("small"));
    let mut sheet = Sheet::new(width, height);
    for (mark, points) in (b'1'..=b'9').chain(b'a'..=b'z').zip(polygons) {
        tiler.draw(&at(width, height, points), &mut Solid(mark), &mut sheet, None);
    }
    text(width, &sheet.pixels.iter().map(|p| p.unwrap_or(b'.')).collect::<Vec<_>>())
}

fn text(width: u32, pixels: &[u8]) -> String {
    let row = |row: &[u8]| row.iter().copied().map(char::from).chain(['\n']).collect::<String>();
    pixels.chunks(width as usize).map(row).collect()
}

/// Draws one polygon.
fn pattern(width: u32, height: u32, points: &[[f64; 2]]) -> String {
    picture(width, height, &[points]).replace('1', "#")
}

/// The rows of a drawing, without the spaces before them.
fn drawing(rows: &str) -> String {
    rows.split_whitespace().map(|row| row.to_owned() + "\n").collect()
}

macro_rules! assert_pattern {
    ($left:expr, $right:expr) => {
        let (left, right) = ($left, drawing($right));
        assert!(left == right, "drawn:\n{left}expected:\n{right}");
    };
}

#[test]
fn pattern_of_a_rectangle_on_the_sides_of_pixels() {
    assert_pattern!(
        pattern(8, 4, &[[1.0, 1.0], [1.0, 3.0], [5.0, 3.0], [5.0, 1.0]]),
        "........
         .####...
         .####...
         ........"
    );
}

#[test]
fn pattern_of_a_rectangle_on_centres_has_its_top_and_left_ones() {
    assert_pattern!(
        pattern(8, 4, &[[1.5, 0.5], [1.5, 2.5], [5.5, 2.5], [5.5, 0.5]]),
        ".####...
         .####...
         ........
         ........"
    );
}

#[test]
fn pattern_of_a_triangle_on_centres() {
    // The left edge and the top are in; the diagonal is a right edge.
    assert_pattern!(
        pattern(8, 8, &[[1.5, 1.5], [1.5, 6.5], [6.5, 1.5]]),
        "........
         .#####..
         .####...
         .###....
         .##.....
         .#......
         ........
         ........"
    );
    // Turned round, the diagonal is a left edge, and the bottom is out.
    assert_pattern!(
        pattern(8, 8, &[[6.5, 6.5], [6.5, 1.5], [1.5, 6.5]]),
        "........
         ........
         .....#..
         ....##..
         ...###..
         ..####..
         ........
         ........"
    );
}

/// A step of the grid from a centre decides.
#[test]
fn pattern_of_a_step_of_the_grid_beside_a_centre() {
    let step = 1.0 / 65536.0;
    let column = |x: f64| pattern(4, 1, &[[x, 0.0], [x, 1.0], [4.0, 1.0], [4.0, 0.0]]);
    assert_pattern!(column(1.5 - step), ".###");
    assert_pattern!(column(1.5), ".###");
    assert_pattern!(column(1.5 + step), "..##");
    // Half a step: to the even neighbour, which is the centre.
    assert_pattern!(column(1.5 + step / 2.0), ".###");
    assert_pattern!(column(1.5 + step * 0.51), "..##");
    let row = |y: f64| pattern(1, 4, &[[0.0, 0.0], [0.0, y], [1.0, y], [1.0, 0.0]]);
    assert_pattern!(row(2.5 + step), "# # # .");
    assert_pattern!(row(2.5), "# # . .");
}

/// With the n.8 grid the same places are a step of 1/256 apart.
#[test]
fn pattern_of_the_coarse_grid() {
    let viewport = Viewport::new(0, 0, 4, 1).expect("small");
    let column = |x: f64, grid| {
        let mut sheet = Sheet::new(4, 1);
        let points = at(4, 1, &[[x, 0.0], [x, 1.0], [4.0, 1.0], [4.0, 0.0]]);
        Tiler::new(viewport.with_grid(grid)).draw(&points, &mut Solid(b'#'), &mut sheet, None);
        text(4, &sheet.pixels.iter().map(|p| p.unwrap_or(b'.')).collect::<Vec<_>>())
    };
    assert_pattern!(column(1.5 + 0.4 / 256.0, Grid::Eight), ".###");
    assert_pattern!(column(1.5 + 0.4 / 256.0, Grid::Sixteen), "..##");
    assert_pattern!(column(1.5 + 0.6 / 256.0, Grid::Eight), "..##");
}

#[test]
fn pattern_of_a_shared_diagonal() {
    let (a, b, c, d) = ([0.5, 0.5], [6.5, 0.5], [6.5, 6.5], [0.5, 6.5]);
    // From the lower left corner to the upper right one, through centres: those are on the left
    // edge of the second triangle.
    assert_pattern!(
        picture(8, 8, &[&[a, b, d], &[b, c, d]]),
        "111111..
         111112..
         111122..
         111222..
         112222..
         122222..
         ........
         ........"
    );
    // From the upper left corner to the lower right one, the lists the other way round: the
    // centres are on the left edge of the first.
    assert_pattern!(
        picture(8, 8, &[&[c, b, a], &[a, c, d]]),
        "111111..
         211111..
         221111..
         222111..
         222211..
         222221..
         ........
         ........"
    );
}

/// A closed fan round a centre, with edges through centres in all eight octants and along both
/// axes. Each centre on an edge belongs to the part on its right, or below it.
#[test]
fn pattern_of_a_fan_through_centres_in_all_octants() {
    let hub = [8.5, 8.5];
    let eighth = [[6.0, 0.0], [6.0, 3.0], [6.0, 6.0], [3.0, 6.0]];
    let quarter = |[x, y]: [f64; 2]| [-y, x];
    let rim: Vec<[f64; 2]> = (0..16)
        .map(|i| (0..i / 4).fold(eighth[i % 4], |p, _| quarter(p)))
        .map(|p| [hub[0] + p[0], hub[1] + p[1]])
        .collect();
    let parts: Vec<[[f64; 2]; 3]> = (0..16).map(|i| [hub, rim[i], rim[(i + 1) % 16]]).collect();
    let slices: Vec<&[[f64; 2]]> = parts.iter().map(|p| &p[..]).collect();
    let fan = picture(16, 16, &slices);
    assert_pattern!(
        fan.clone(),
        "................
         ................
         ..bbbcccdddeee..
         ..abbbccdddeef..
         ..aabbccddeeff..
         ..aaabbcddefff..
         ..99aabcdeffgg..
         ..9999abdfgggg..
         ..888888111111..
         ..888876421111..
         ..887765432211..
         ..777665443222..
         ..776655443322..
         ..766655444332..
         ................
         ................"
    );
    // Together they are the outline.
    let whole: String =
        fan.chars().map(|c| if c.is_whitespace() || c == '.' { c } else { '#' }).collect();
    assert_eq!(pattern(16, 16, &rim), whole);
}

/// Thinner than a pixel: what is drawn are the centres in it, and on its left edge.
#[test]
fn pattern_of_slivers_through_centres() {
    let hair = 1.0 / 65536.0;
    // To the right of the line through centres: they are on its left edge.
    assert_pattern!(
        pattern(16, 8, &[[0.5, 0.5], [14.5, 7.5], [14.5 + hair, 7.5]]),
        "................
         ..#.............
         ....#...........
         ......#.........
         ........#.......
         ..........#.....
         ............#...
         ................"
    );
    // To the left of it: they are on its right edge.
    assert_pattern!(
        pattern(16, 8, &[[0.5, 0.5], [14.5, 7.5], [14.5 - hair, 7.5]]),
        "................
         ................
         ................
         ................
         ................
         ................
         ................
         ................"
    );
    // Lying, below and above a row of centres.
    assert_pattern!(
        pattern(8, 2, &[[0.5, 0.5], [7.5, 0.5], [7.5, 0.5 + hair]]),
        "#######. ........"
    );
    assert_pattern!(
        pattern(8, 2, &[[0.5, 0.5], [7.5, 0.5], [7.5, 0.5 - hair]]),
        "........ ........"
    );
    // Standing.
    assert_pattern!(pattern(2, 4, &[[0.5, 0.0], [0.5, 4.0], [0.5 + hair, 2.0]]), "#. #. #. #.");
    assert_pattern!(pattern(2, 4, &[[0.5, 0.0], [0.5, 4.0], [0.5 - hair, 2.0]]), ".. .. .. ..");
}

/// Not convex: what the outline winds round, also more than once, is drawn, once.
#[test]
fn pattern_of_outlines_that_are_not_convex() {
    // An arrow head: two spans in a row.
    assert_pattern!(
        pattern(16, 8, &[[1.0, 0.0], [8.0, 5.0], [15.0, 0.0], [8.0, 8.0]]),
        ".#............#.
         ..#..........#..
         ...#.......##...
         ....##....##....
         .....##..##.....
         ......####......
         .......##.......
         ................"
    );
    // A bow tie: both halves, though their areas cancel.
    assert_pattern!(
        pattern(16, 8, &[[1.0, 0.0], [15.0, 8.0], [15.0, 0.0], [1.0, 8.0]]),
        ".#............#.
         .###........###.
         .####......####.
         .######..######.
         .######..######.
         .####......####.
         .###........###.
         .#............#."
    );
    // A pentagram: its middle is wound round twice.
    assert_pattern!(
        pattern(16, 16, &[[8.0, 0.0], [13.0, 15.0], [0.0, 6.0], [16.0, 6.0], [3.0, 15.0]]),
        "................
         .......#........
         .......##.......
         .......##.......
         ......###.......
         ......####......
         .##############.
         ..############..
         ....########....
         .....######.....
         ....#######.....
         ....########....
         ....###..###....
         ...##......#....
         ...#........#...
         ................"
    );
    // A frame: the inner square the other way round is a hole.
    let frame = [
        [1.0, 1.0],
        [1.0, 7.0],
        [7.0, 7.0],
        [7.0, 1.0],
        [1.0, 1.0],
        [3.0, 3.0],
        [5.0, 3.0],
        [5.0, 5.0],
        [3.0, 5.0],
        [3.0, 3.0],
    ];
    assert_pattern!(
        pattern(8, 8, &frame),
        "........
         .######.
         .######.
         .##..##.
         .##..##.
         .######.
         .######.
         ........"
    );
}

/// Points, lines, and outlines that turn back on themselves.
#[test]
fn pattern_of_nothing() {
    let nothing: [&[[f64; 2]]; 8] = [
        &[],
        &[[1.5, 1.5]],
        &[[0.5, 0.5], [3.5, 3.5]],
        &[[1.5, 1.5], [1.5, 1.5], [1.5, 1.5]],
        &[[0.5, 0.5], [2.5, 2.5], [3.5, 3.5]],
        &[[0.5, 1.5], [3.5, 1.5], [2.5, 1.5]],
        &[[1.5, 0.5], [1.5, 3.5], [1.5, 2.5], [1.5, 0.5]],
        &[[0.5, 0.5], [3.5, 0.5], [3.5, 3.5], [3.5, 0.5]],
    ];
    for points in nothing {
        assert_pattern!(pattern(4, 4, points), ".... .... .... ....");
    }
}

/// A part of the viewport as target: its rows have their own stride, and what lies between them
/// is left alone.
#[test]
fn pattern_in_a_target_with_a_stride() {
    let mut data = [b'-'; 6 * 7];
    let mut plane = Plane::with_stride(&mut data, 4, 7, 6).expect("42 elements");
    plane.clear(b'.');
    let mut tiler = Tiler::new(Viewport::new(0, 0, 8, 8).expect("small"));
    tiler.set_origin(2, 1);
    let diamond = at(8, 8, &[[4.0, 0.0], [0.0, 4.0], [4.0, 8.0], [8.0, 4.0]]);
    tiler.draw(&diamond, &mut Solid(b'#'), &mut plane, None);
    assert_pattern!(
        text(6, &data),
        "###.--
         ####--
         ####--
         ####--
         ####--
         ###.--
         .#..--"
    );
}

/// Row by row, each a target of its own: what lies beyond its only row is never looked for, however far it would be.
#[test]
fn pattern_in_single_rows_with_any_stride() {
    let viewport = Viewport::new(-4, -4, 16, 16).expect("small");
    // In perspective, so that it goes the way of small triangles.
    let corner = |x: f64, y: f64, w: f64| unproject(viewport, [x + 4.0, y + 4.0], w / 5.0, w);
    let corners = [corner(0.0, 0.0, 1.0), corner(0.0, 8.0, 2.0), corner(4.0, 8.0, 3.0)];
    let sliver = Poly::bare(&corners);
    for stride in [8, usize::MAX / 2, usize::MAX] {
        let rows: String = (0..8)
            .map(|y| {
                let (mut data, mut depths) = ([b'.'; 8], [1.0; 8]);
                let mut plane = Plane::with_stride(&mut data, 8, 1, stride).expect("one row");
                let mut depth = Plane::with_stride(&mut depths, 8, 1, stride).expect("one row");
                let mut tiler = Tiler::new(viewport);
                tiler.set_origin(0, y);
                tiler.draw(&sliver, &mut Solid(b'#'), &mut plane, Some(&mut depth));
                for (pixel, depth) in data.iter().zip(depths) {
                    assert_eq!(*pixel == b'#', depth < 1.0, "row {y}");
                }
                text(8, &data)
            })
            .collect();
        assert_pattern!(
            rows,
            "........
             #.......
             #.......
             ##......
             ##......
             ###.....
             ###.....
             ####...."
        );
    }
}

/// A viewport that sticks out of the target at all sides, and one that lies beyond it.
#[test]
fn pattern_of_a_viewport_beyond_the_target() {
    let diamond = at(8, 8, &[[4.0, 0.0], [0.0, 4.0], [4.0, 8.0], [8.0, 4.0]]);
    let shown = |x: i32, y: i32| {
        let viewport = Viewport::new(x, y, 8, 8).expect("small");
        let mut sheet = Sheet::new(6, 4);
        let outcome = Tiler::new(viewport).draw(&diamond, &mut Solid(b'#'), &mut sheet, None);
        assert_eq!(outcome, Outcome::Drawn);
        text(6, &sheet.pixels.iter().map(|p| p.unwrap_or(b'.')).collect::<Vec<_>>())
    };
    assert_pattern!(shown(0, 0), "...#.. ..###. .##### ######");
    assert_pattern!(shown(-1, -2), "#####. ###### ###### #####.");
    assert_pattern!(shown(3, 2), "...... ...... ...... .....#");
    assert_pattern!(shown(-3, -5), "###... ##.... #..... ......");
    assert_pattern!(shown(6, 0), "...... ...... ...... ......");
    assert_pattern!(shown(i32::MAX - 4, i32::MIN + 4), "...... ...... ...... ......");
}

/// The polygon sticks out of the viewport, the target has more room: nothing is drawn beside it.
#[test]
fn pattern_of_a_polygon_beyond_the_viewport() {
    let viewport = Viewport::new(2, 1, 4, 2).expect("small");
    let mut sheet = Sheet::new(8, 4);
    let cover = [[-9.0, -9.0, 0.5, 1.0], [9.0, -9.0, 0.5, 1.0], [0.0, 30.0, 0.5, 1.0]];
    Tiler::new(viewport).draw(&Poly::bare(&cover), &mut Solid(b'#'), &mut sheet, None);
    assert_eq!(viewport.rect(), PixelRect { x0: 2, y0: 1, x1: 6, y1: 3 });
    assert_pattern!(
        text(8, &sheet.pixels.iter().map(|p| p.unwrap_or(b'.')).collect::<Vec<_>>()),
        "........
         ..####..
         ..####..
         ........"
    );
}
