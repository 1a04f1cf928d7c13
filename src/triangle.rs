//! Small triangles within the view volume: from places on the grid to covered pixels.
//!
//! Most polygons are small triangles that nothing clips. For them this does what edges and spans
//! do for any polygon, and to the same pixels. What is not such a triangle is left to those.

use fearless_simd::{Level, dispatch};

use crate::fixed::Subpixel;
use crate::patch::Patches;
use crate::placed::PlacedVertex;
use crate::space::PixelRect;

/// A small triangle within the view volume that covers some pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct InView {
    pub(crate) patches: Patches,
    /// Pixels of the framebuffer that it may cover.
    pub(crate) bounds: PixelRect,
    pub(crate) pixels: u64,
    pub(crate) spans: u64,
}

/// What became of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// It is not small, or not within the view volume.
    Elsewhere,
    /// No area, once snapped.
    Degenerate,
    /// It faces away.
    Away,
    /// No pixel's centre is covered, or none in the window.
    Nothing,
    /// [`InView`] tells.
    Pixels,
}

/// The longest side of a small triangle's bounding box, with 16 fraction bits.
const LARGEST: i32 = 256 << Subpixel::FRACTION_BITS;

/// Looks at the triangle of `vertices`, from the viewport's `corner` in the framebuffer, and fills
/// `found` in if it covers any pixel of `window`. It faces away unless `wants` says otherwise of
/// its side, the front or not.
#[inline(always)]
pub(crate) fn look(
    level: Level,
    vertices: [PlacedVertex; 3],
    corner: [i32; 2],
    wants: impl Fn(bool) -> bool,
    window: PixelRect,
    found: &mut InView,
) -> Look {
    let [a, b, c] = vertices;
    if !(a.within & b.within & c.within) {
        return Look::Elsewhere;
    }
    let ([ax, ay], [bx, by], [cx, cy]) = (a.bits, b.bits, c.bits);
    let (low_x, high_x) = (ax.min(bx).min(cx), ax.max(bx).max(cx));
    let (low_y, high_y) = (ay.min(by).min(cy), ay.max(by).max(cy));
    // Within the view volume: no difference overflows.
    if (high_x - low_x) | (high_y - low_y) >= LARGEST {
        return Look::Elsewhere;
    }
    let wide = |a: i32, b: i32| i64::from(a - b);
    let area = wide(by, ay) * wide(cx, ax) - wide(bx, ax) * wide(cy, ay);
    if area == 0 {
        return Look::Degenerate;
    }
    let front = area > 0;
    if !wants(front) {
        return Look::Away;
    }
    let first = Subpixel::first_centre_of;
    let (x0, y0, x1, y1) = (first(low_x), first(low_y), first(high_x), first(high_y));
    if x0 >= x1 || y0 >= y1 {
        return Look::Nothing;
    }
    let [corner_x, corner_y] = corner;
    // The viewport may lie at the end of all columns or rows.
    let (Some(end_x), Some(end_y)) = (x1.checked_add(corner_x), y1.checked_add(corner_y)) else {
        return Look::Elsewhere;
    };
    let bounds = PixelRect { x0: x0 + corner_x, y0: y0 + corner_y, x1: end_x, y1: end_y };
    let Some(patches) = Patches::of(bounds) else { return Look::Elsewhere };
    found.patches = patches;
    let (x, y) = (Subpixel::centre_bits(x0), Subpixel::centre_bits(y0));
    let from_first = |[px, py]: [i32; 2]| [f64::from(px - x), f64::from(py - y)];
    let vertices = [from_first(a.bits), from_first(b.bits), from_first(c.bits)];
    let patches = &mut found.patches;
    (found.pixels, found.spans) =
        dispatch!(level, simd => patches.cover(simd, vertices, front, window));
    found.bounds = bounds;
    if found.pixels > 0 { Look::Pixels } else { Look::Nothing }
}
