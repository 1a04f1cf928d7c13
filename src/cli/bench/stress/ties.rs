//! Polygons with a value that lies almost halfway between two `f32`: what `Exact` has to tell
//! apart, and what no random polygon has.

use hyperspan::error::Error;
use hyperspan::space::Viewport;

use super::super::reference::{Reference, Value};
use super::judge::Quantity;
use super::random::Random;
use super::shape::{Case, Shape, window};

/// A triangle whose first vertex has been moved so that the value at one pixel is within 2^-20 of
/// the midpoint between two `f32`, and then by `halvings` of the way that was left.
///
/// # Errors
/// None: the viewport is a small one.
pub(super) fn near_a_tie(halvings: f64, index: usize, random: &mut Random) -> Result<Case, Error> {
    let viewport = Viewport::new(0, 0, 512, 512)?;
    let shape = Shape::triangle(viewport, 100.0, random);
    let at = shape.at([0.3, 0.3, 0.4]);
    let mut case = shape.case(vec![window(viewport, at)]);
    let quantity = Quantity::ALL[index % Quantity::ALL.len()];
    if let Some(x) = nearer(&case, at.map(|c| c as i32), quantity, halvings as u32) {
        case.positions[0][0] = x;
    }
    Ok(case)
}

/// The x of the first vertex that brings `quantity` at `pixel` near the midpoint; nothing if it
/// cannot be had that way.
fn nearer(case: &Case, pixel: [i32; 2], quantity: Quantity, halvings: u32) -> Option<f64> {
    // Some units of f32 to either side, and less than a thousandth of a pixel.
    const REACH: f64 = 1.0 / (1_u64 << 20) as f64;
    let mut positions = case.positions.clone();
    let given = positions[0][0];
    let mut moved = |by: f64| {
        positions[0][0] = given * (1.0 + by);
        let reference = Reference::new(&positions, &case.attributes, &case.viewport)?;
        let [x, y] = pixel;
        match quantity {
            Quantity::Attribute => reference.attribute(0, x, y),
            Quantity::Depth => reference.depth(x, y),
            Quantity::W => reference.w(x, y),
            Quantity::InvW => reference.inv_w(x, y),
        }
    };
    let rounded = moved(0.0)?.high as f32;
    let middle = (f64::from(rounded) + f64::from(rounded.next_up())) / 2.0;
    let above = |value: Value| (value.high - middle) + value.low > 0.0;
    let [mut one, mut other] = [-REACH, REACH];
    let rises = above(moved(other)?);
    if above(moved(one)?) == rises {
        return None;
    }
    for _ in 0..halvings {
        let between = (one + other) / 2.0;
        if above(moved(between)?) == rises {
            other = between;
        } else {
            one = between;
        }
    }
    Some(given * (1.0 + one))
}
