//! Small triangles within the view volume: from places on the grid to covered pixels.
//!
//! Most polygons are small triangles that nothing clips. For them this does what edges and spans
//! do for any polygon, and to the same pixels. What is not such a triangle is left to those.

use fearless_simd::Simd;

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
/// `found` in if it covers any pixel of `window`. `wants`: are back faces drawn, and front faces?
#[inline(always)]
pub(crate) fn look<S: Simd>(
    simd: S,
    vertices: [PlacedVertex; 3],
    corner: [i32; 2],
    wants: [bool; 2],
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
    let (to_b, to_c) = ([bx - ax, by - ay], [cx - ax, cy - ay]);
    let area = i64::from(to_b[1]) * i64::from(to_c[0]) - i64::from(to_b[0]) * i64::from(to_c[1]);
    if area == 0 {
        return Look::Degenerate;
    }
    let front = area > 0;
    if !wants[usize::from(front)] {
        return Look::Away;
    }
    let (x0, y0) = (Subpixel::first_centre_of(low_x), Subpixel::first_centre_of(low_y));
    let (x1, y1) = (Subpixel::first_centre_of(high_x), Subpixel::first_centre_of(high_y));
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
    let vertices = [[ax - x, ay - y], [bx - x, by - y], [cx - x, cy - y]];
    let patches = &mut found.patches;
    (found.pixels, found.spans) = patches.cover(simd, vertices, front, window);
    found.bounds = bounds;
    if found.pixels > 0 { Look::Pixels } else { Look::Nothing }
}
