//! Short spans: from runs of pixels to patches.
//!
//! A span of a few pixels leaves most lanes of a block empty. So rows that follow one another, and lie about
//! below one another, share the lanes of a patch: as many as 16 lanes hold of the columns between the leftmost and
//! the rightmost of them.

use alloc::vec::Vec;

use crate::edge::Span;
use crate::patch::Patch;
use crate::shade::BLOCK;

/// Lanes of a patch.
const LANES: i32 = BLOCK as i32;

/// Covers the pixels of `spans`, which come row by row, with `patches`; `corner` is what they count from, in the
/// framebuffer.
pub(crate) fn pack(spans: &[Span], corner: [i32; 2], patches: &mut Vec<Patch>) {
    patches.clear();
    let mut left = spans;
    while let Some(first) = left.first() {
        let (mut start, mut end) = (first.start, first.end);
        let mut count = 1;
        for span in &left[1..] {
            let rows = span.row - first.row + 1;
            let (leftmost, rightmost) = (start.min(span.start), end.max(span.end));
            if rows > LANES || (rightmost - leftmost) * rows > LANES {
                break;
            }
            (start, end) = (leftmost, rightmost);
            count += 1;
        }
        let (together, others) = left.split_at(count);
        left = others;
        let place = [start + corner[0], first.row + corner[1]];
        if end - start > LANES {
            cut(place, end - start, patches);
            continue;
        }
        let columns = end - start;
        let mut mask = 0;
        for span in together {
            let lane = (span.row - first.row) * columns + span.start - start;
            mask |= ((1_u32 << (span.end - span.start)) - 1) << lane;
        }
        patches.push(Patch { first: place, columns: columns as u16, mask: mask as u16 });
    }
}

/// Cuts a run of so many pixels from `x`, `y` on into patches.
#[cold]
fn cut([x, y]: [i32; 2], pixels: i32, patches: &mut Vec<Patch>) {
    for column in (0..pixels).step_by(BLOCK) {
        let columns = (pixels - column).min(LANES);
        let mask = u16::MAX >> (LANES - columns);
        patches.push(Patch { first: [x + column, y], columns: columns as u16, mask });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each pixel of the spans is a lane of just one patch, and no other pixel is.
    #[test]
    fn patches_of_spans_have_their_pixels() {
        let corner = [-5, 7];
        let mut state = 1_u32;
        let mut next = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((state >> 16) % below).cast_signed()
        };
        let mut patches = Vec::new();
        let (mut pixels_of_all, mut patches_of_all) = (0, 0);
        for _ in 0..2000 {
            let (mut spans, mut row) = (Vec::new(), 0);
            let (most, slant) = ([2, 4, 9, 40][next(4) as usize], next(9) - 4);
            for _ in 0..next(30) {
                // Now and then a row has two, or none.
                let mut start = 300 + row * slant + next(3);
                for _ in 0..=next(8) / 7 {
                    let end = start + 1 + next(most);
                    spans.push(Span { row, start, end, left: [0; 2], right: [0; 2] });
                    start = end + 1 + next(3);
                }
                row += 1 + next(8) / 7;
            }
            pack(&spans, corner, &mut patches);
            let mut expected = Vec::new();
            for Span { row, start, end, .. } in spans {
                expected.extend((start..end).map(|column| [row + corner[1], column + corner[0]]));
            }
            let mut found = Vec::new();
            for patch in &patches {
                let lanes = (0..BLOCK).filter(|lane| patch.mask >> lane & 1 != 0);
                found.extend(lanes.map(|lane| {
                    let [x, y] = patch.place(lane, [-10_000; 2]).map(|c| c.cast_signed() - 10_000);
                    [y, x]
                }));
            }
            found.sort_unstable();
            assert_eq!(found, expected);
            (pixels_of_all, patches_of_all) =
                (pixels_of_all + found.len(), patches_of_all + patches.len());
        }
        assert!(pixels_of_all > 5 * patches_of_all, "{pixels_of_all} in {patches_of_all}");
    }
}
