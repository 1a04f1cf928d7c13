//! Clears that are put off until something is drawn: what a polygon covers, and passes against what it would
//! have been cleared to, is never cleared.

use crate::depth::Compare;
use crate::gradient::enclosure::Enclosure;
use crate::space::PixelRect;
use crate::target::{DepthBuffer, Target};

impl DepthBuffer<'_> {
    /// Clears all depths to `depth`, and a target of the same size to its
    /// [`background`](Target::background), but not yet: drawing does, where it has to. Says no, with nothing
    /// done, if the buffer has no bounds ([`with_bounds`](Self::with_bounds)).
    ///
    /// From then on nothing but a [`Tiler`](crate::tiler::Tiler) may look at the two or write to them, and both
    /// at once, and neither may be cut between rows, until [`clear_rest`](Self::clear_rest) is called with the
    /// target: it has to be, else bounds and depths say different things. It is what
    /// [`Canvas::clear_later`](crate::draw::Canvas::clear_later) is made of, which says when it pays.
    ///
    /// ```
    /// # use hyperspan::{DepthBounds, Plane, Solid, Tiler, Vertex, Viewport};
    /// let (mut pixels, mut depths, mut bounds) = ([7_u8; 64], [0.0_f32; 64], DepthBounds::new());
    /// let mut target = Plane::new(&mut pixels, 8, 8)?.with_background(0);
    /// let mut depth = Plane::new(&mut depths, 8, 8)?.with_bounds(&mut bounds);
    /// assert!(depth.clear_later(1.0));
    /// let corner = |x, y| Vertex::new([x, y, 0.5, 1.0], []);
    /// let triangle = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0)];
    /// let mut tiler = Tiler::new(Viewport::new(0, 0, 8, 8)?);
    /// tiler.draw(&triangle, &mut Solid(1), &mut target, Some(&mut depth));
    /// depth.clear_rest(&mut target);
    /// // The lower left corner is covered, the upper right one is not.
    /// assert_eq!((pixels[56], pixels[7], depths[7]), (1, 0, 1.0));
    /// # Ok::<(), hyperspan::Error>(())
    /// ```
    pub fn clear_later(&mut self, depth: f32) -> bool {
        let (width, _) = self.dimensions();
        let Some(bounds) = self.bounds_mut() else { return false };
        bounds.clear();
        bounds.unclear.put_off(width, depth);
        true
    }

    /// Clears what [`clear_later`](Self::clear_later) has left of this buffer and `target`.
    pub fn clear_rest<T: Target + ?Sized>(&mut self, target: &mut T) {
        self.clear_rows(target, [0, u32::MAX]);
    }

    /// May anything be left to be cleared from the first to the last of these rows?
    #[inline(always)]
    pub(crate) fn may_be_unclear(&self, rows: [u32; 2]) -> bool {
        self.bounds().is_some_and(|bounds| bounds.unclear.may_reach(rows))
    }

    /// Is anything left to be cleared there?
    #[inline(never)]
    pub(crate) fn is_unclear(&self, rows: [u32; 2]) -> bool {
        self.bounds().is_some_and(|bounds| bounds.unclear.reaches(rows))
    }

    /// Clears what is left of these rows.
    #[inline(never)]
    pub(crate) fn clear_rows<T: Target + ?Sized>(&mut self, target: &mut T, rows: [u32; 2]) {
        let (Some(bounds), mut depths) = self.apart() else { return };
        let far = bounds.unclear.depth();
        bounds.unclear.take_rows(rows, |y, columns| clear(&mut depths, target, y, columns, far));
    }

    /// Gets `pixels` of a row ready to be drawn, whose depths lie within `depths`. True if none of them has been
    /// cleared and all pass against what they would be cleared to: then no depth there is worth a look. The
    /// buffer's first pixel is at `origin` in the framebuffer.
    #[inline(never)]
    pub(crate) fn take_unclear<T: Target + ?Sized>(
        &mut self,
        target: &mut T,
        pixels: PixelRect,
        origin: [i32; 2],
        depths: &Enclosure,
        compare: Compare,
    ) -> bool {
        let (Some(bounds), mut buffer) = self.apart() else { return false };
        let far = bounds.unclear.depth();
        let from_first = |c: i32, k: usize| c.wrapping_sub(origin[k]).cast_unsigned();
        let (y, columns) =
            (from_first(pixels.y0, 1), [pixels.x0, pixels.x1].map(|x| from_first(x, 0)));
        if !bounds.unclear.reaches([y, y]) {
            return false;
        }
        let clear = |columns| clear(&mut buffer, target, y, columns, far);
        if compare.passes_all(depths.over_pixels(pixels), far) {
            bounds.unclear.take(y, columns, clear)
        } else {
            bounds.unclear.take_row(y, clear);
            false
        }
    }

    /// How many pixels were drawn that had not been cleared, since the last time.
    pub(crate) fn take_drawn_unclear(&mut self) -> u64 {
        self.bounds_mut().map_or(0, |bounds| bounds.unclear.take_drawn())
    }
}

/// Clears columns of a row.
fn clear<T: Target + ?Sized>(
    depths: &mut DepthBuffer<'_>,
    target: &mut T,
    y: u32,
    columns: [u32; 2],
    depth: f32,
) {
    depths.fill(y, columns, depth);
    let (width, height) = target.size();
    let columns = columns.map(|x| x.min(width));
    if let Some(background) = target.background().filter(|_| y < height) {
        target.fill(y, columns, background);
    }
}
