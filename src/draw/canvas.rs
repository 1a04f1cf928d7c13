//! What a draw list is drawn on: targets that can be cut into bands of rows.

use crate::shade::Shader;
use crate::target::{DepthBuffer, Plane, Target};

/// All that is drawn on at once; it can be cut into bands of rows, which are drawn one after the
/// other or by several threads.
pub trait Canvas: Sized + Send {
    /// (width, height) in pixels.
    fn size(&self) -> (u32, u32);

    /// The rows above `row`, which is at most the height, and the others.
    fn split_at_row(self, row: u32) -> (Self, Self);

    /// Makes it what it is before anything is drawn. It is called once for each band, right
    /// before that is drawn, so that what is cleared is still in the cache.
    fn clear(&mut self);

    /// Instead of [`clear`](Self::clear): lets drawing clear what it has to, and says whether it will
    /// ([`DepthBuffer::clear_later`]). What large polygons cover is not cleared then, nor compared with what it
    /// was cleared to, which saves a tenth of the time of a picture that they fill. Only called in lists of few
    /// polygons, if every paint [allows it](Paint::CLEARS).
    fn clear_later(&mut self) -> bool {
        false
    }
}

/// What polygons are drawn with on canvases of the type `C`: a shader, and which parts of the
/// canvas it draws on.
pub trait Paint<C: Canvas>: Sync {
    /// Turns values into pixels.
    type Shader<'c>: Shader
    where
        Self: 'c,
        C: 'c;

    /// Does a pixel that is drawn so, by this or by any other paint of a list, replace all that this
    /// one has drawn there; and do they have the same depth buffer? Then what is hidden in the end
    /// need not be drawn before, if the depth buffer has bounds and the depth test lets the nearer
    /// pass.
    const REPLACES: bool = false;

    /// May the canvas be [cleared later](Canvas::clear_later)? Only if `open` hands out all of it that is to be
    /// cleared, as a target with a [`background`](Target::background) and a depth buffer with bounds, and
    /// looks at none of it, and the shader neither.
    const CLEARS: bool = false;

    /// Stores them.
    type Target<'c>: Target<Pixel = <Self::Shader<'c> as Shader>::Pixel>
    where
        Self: 'c,
        C: 'c;

    /// For a band: what its pixels are shaded with, where they go, and the depths they are tested
    /// against, if they are.
    fn open<'c>(
        &'c self,
        canvas: &'c mut C,
    ) -> (Self::Shader<'c>, Self::Target<'c>, Option<DepthBuffer<'c>>);
}

/// A target that can be cut between two rows.
pub trait Rows: Target + Sized {
    /// What lies above `row`, which is at most the height, and the rest.
    fn split_at_row(self, row: u32) -> (Self, Self);

    /// Sets every pixel.
    fn clear(&mut self, pixel: Self::Pixel);

    /// Makes `pixel` the [`background`](Target::background), if that is possible.
    fn set_background(&mut self, _pixel: Self::Pixel) -> bool {
        false
    }
}

impl<P: Copy + Default + 'static> Rows for Plane<'_, P> {
    fn split_at_row(self, row: u32) -> (Self, Self) {
        Plane::split_at_row(self, row)
    }

    fn clear(&mut self, pixel: P) {
        Plane::clear(self, pixel);
    }

    fn set_background(&mut self, pixel: P) -> bool {
        *self = core::mem::take(self).with_background(pixel);
        true
    }
}

impl Rows for () {
    fn split_at_row(self, _row: u32) -> (Self, Self) {
        ((), ())
    }

    fn clear(&mut self, (): ()) {}

    fn set_background(&mut self, (): ()) -> bool {
        true
    }
}

macro_rules! tuple_rows {
    ($($name:ident $i:tt),+) => {
        impl<$($name: Rows),+> Rows for ($($name,)+) {
            fn split_at_row(self, row: u32) -> (Self, Self) {
                let parts = ($(self.$i.split_at_row(row),)+);
                (($(parts.$i.0,)+), ($(parts.$i.1,)+))
            }

            fn clear(&mut self, pixel: Self::Pixel) {
                $(self.$i.clear(pixel.$i);)+
            }

            fn set_background(&mut self, pixel: Self::Pixel) -> bool {
                $(self.$i.set_background(pixel.$i))&&+
            }
        }
    };
}

tuple_rows!(A 0, B 1);
tuple_rows!(A 0, B 1, C 2);
tuple_rows!(A 0, B 1, C 2, D 3);

/// The usual canvas: a target, and depth.
#[derive(Debug)]
pub struct Screen<'a, T: Target> {
    /// Where pixels go.
    pub target: T,
    /// Depths, if there is a test: of the target's size at least.
    pub depth: Option<DepthBuffer<'a>>,
    /// What is cleared to: the target, and depth. Without it nothing is cleared.
    pub clear: Option<(T::Pixel, f32)>,
}

impl<T: Rows + Send> Canvas for Screen<'_, T>
where
    T::Pixel: Send,
{
    fn size(&self) -> (u32, u32) {
        let (width, height) = self.target.size();
        match &self.depth {
            Some(depth) => {
                let (w, h) = depth.dimensions();
                (width.min(w), height.min(h))
            }
            None => (width, height),
        }
    }

    fn split_at_row(self, row: u32) -> (Self, Self) {
        let (above, below) = self.target.split_at_row(row);
        let (depth_above, depth_below) = match self.depth.map(|depth| depth.split_at_row(row)) {
            Some((above, below)) => (Some(above), Some(below)),
            None => (None, None),
        };
        let clear = self.clear;
        (
            Self { target: above, depth: depth_above, clear },
            Self { target: below, depth: depth_below, clear },
        )
    }

    fn clear(&mut self) {
        if let Some((pixel, far)) = self.clear {
            self.target.clear(pixel);
            if let Some(depth) = &mut self.depth {
                depth.clear(far);
            }
        }
    }

    fn clear_later(&mut self) -> bool {
        let (Some((pixel, far)), Some(depth)) = (self.clear, &mut self.depth) else { return false };
        // What has no size need not be cleared.
        let is_same = self.target.size() == depth.dimensions() || size_of::<T::Pixel>() == 0;
        is_same && self.target.set_background(pixel) && depth.clear_later(far)
    }
}

/// Draws on a [`Screen`] with a copy of the shader for each band.
#[derive(Clone, Copy, Debug)]
pub struct With<S>(pub S);

impl<'a, T, S> Paint<Screen<'a, T>> for With<S>
where
    T: Rows + Send,
    T::Pixel: Send,
    S: Shader<Pixel = T::Pixel> + Clone + Sync,
{
    const REPLACES: bool = T::REPLACES;
    const CLEARS: bool = true;

    type Shader<'c>
        = S
    where
        Self: 'c,
        Screen<'a, T>: 'c;
    type Target<'c>
        = &'c mut T
    where
        Self: 'c,
        Screen<'a, T>: 'c;

    fn open<'c>(
        &'c self,
        canvas: &'c mut Screen<'a, T>,
    ) -> (S, &'c mut T, Option<DepthBuffer<'c>>) {
        (self.0.clone(), &mut canvas.target, canvas.depth.as_mut().map(DepthBuffer::reborrow))
    }
}
