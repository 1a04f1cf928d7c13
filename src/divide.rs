//! The division by w, and the viewport: from clipped vertices to those on the subpixel grid.
//!
//! Never before clipping. Positions are kept twice: unsnapped, for attributes, and snapped, for
//! coverage. What is interpolated without perspective needs s itself; with it, s/w and 1/w:
//! [`divide_array`] gives the whole array.

use alloc::vec::Vec;

use crate::clip::VertexArrays;
use crate::fixed::Subpixel;
use crate::space::Viewport;

/// A vertex in the framebuffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenVertex {
    /// Framebuffer x, y in pixels, not snapped.
    pub framebuffer: [f64; 2],
    /// The same from the viewport's upper left corner, snapped.
    pub snapped: [Subpixel; 2],
    /// Which of the clipped vertices it is.
    pub vertex: u32,
}

/// Divides `positions` by w, takes them through `viewport` and snaps them into `out`, which is
/// cleared first. A vertex that names no place, (0, 0, 0, 0), is left out.
#[inline(always)]
pub fn divide(
    positions: impl Iterator<Item = [f64; 4]>,
    viewport: Viewport,
    out: &mut Vec<ScreenVertex>,
) {
    out.clear();
    let [half_w, half_h] = viewport.half_size();
    let [centre_x, centre_y] = viewport.centre();
    let corner = viewport.rect();
    for (vertex, [x, y, _, w]) in (0_u32..).zip(positions) {
        // The clipper leaves no other w than this and w > 0, but for a hair.
        if w <= 0.0 {
            continue;
        }
        let framebuffer = [(x / w) * half_w + centre_x, centre_y - (y / w) * half_h];
        let snapped = [
            Subpixel::snap(framebuffer[0], corner.x0, viewport.grid()),
            Subpixel::snap(framebuffer[1], corner.y0, viewport.grid()),
        ];
        out.push(ScreenVertex { framebuffer, snapped, vertex });
    }
}

/// The whole array of vertex `i`, the constant 1 included, divided by w: x/w, y/w, z/w, 1/w,
/// s_0/w, s_1/w, ... (Blinn 1992; Heckbert and Moreton 1991).
pub fn divide_array(vertices: &VertexArrays, i: usize) -> impl Iterator<Item = f64> {
    let [x, y, z, w] = vertices.position(i);
    [x, y, z, 1.0].into_iter().chain(vertices.attributes(i).iter().copied()).map(move |n| n / w)
}

/// Twice the area that the snapped vertices enclose, with 32 fraction bits, exactly; positive
/// for counter-clockwise ones (y up).
#[inline(always)]
pub fn snapped_area(vertices: &[ScreenVertex]) -> i128 {
    if let [a, b, c] = vertices {
        let (ax, ay) = (a.snapped[0].wide(), a.snapped[1].wide());
        let (bx, by) = (b.snapped[0].wide() - ax, b.snapped[1].wide() - ay);
        let (cx, cy) = (c.snapped[0].wide() - ax, c.snapped[1].wide() - ay);
        let largest = bx.abs().max(by.abs()).max(cx.abs()).max(cy.abs());
        if largest < 1 << 30 {
            return i128::from(by * cx - bx * cy);
        }
    }
    let Some(last) = vertices.last() else { return 0 };
    let [mut x, mut y] = last.snapped.map(Subpixel::wide);
    let mut area = 0_i128;
    for vertex in vertices {
        let [next_x, next_y] = vertex.snapped.map(Subpixel::wide);
        // y points down: turned round.
        area += i128::from(y * next_x) - i128::from(x * next_y);
        (x, y) = (next_x, next_y);
    }
    area
}
