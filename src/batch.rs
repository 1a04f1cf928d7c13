//! Many polygons at once, however they are kept: what a draw list is made of.

use alloc::vec::Vec;

use crate::cull::Clusters;
use crate::error::Error;
use crate::placed::Placed;
use crate::polygon::{Indexed, Polygon};

/// Polygons by number, which can be asked for in any order and from any thread.
pub trait Batch: Sync {
    /// One of them.
    type Polygon<'a>: Polygon
    where
        Self: 'a;

    /// How many there are.
    fn len(&self) -> usize;

    /// Is there none?
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Polygon `i`, below [`len`](Self::len).
    fn polygon(&self, i: usize) -> Self::Polygon<'_>;

    /// Boxes over its polygons, if there are any: with them whole runs are left out that are outside of
    /// the view, and count as that, and what hides others is found among many.
    fn clusters(&self) -> Option<Clusters<'_>> {
        None
    }

    /// Is polygon `i` a part of the same face as the one before it? Of the parts of a face, those
    /// counts of [`Stats`](crate::stats::Stats) that are of polygons count one: as drawn if any
    /// of it is, else as the first part.
    #[inline(always)]
    fn continues(&self, _i: usize) -> bool {
        false
    }
}

impl<B: Batch + ?Sized> Batch for &B {
    type Polygon<'a>
        = B::Polygon<'a>
    where
        Self: 'a;

    fn len(&self) -> usize {
        (**self).len()
    }

    #[inline(always)]
    fn polygon(&self, i: usize) -> B::Polygon<'_> {
        (**self).polygon(i)
    }

    fn clusters(&self) -> Option<Clusters<'_>> {
        (**self).clusters()
    }

    #[inline(always)]
    fn continues(&self, i: usize) -> bool {
        (**self).continues(i)
    }
}

impl<P: Polygon + Sync> Batch for [P] {
    type Polygon<'a>
        = &'a P
    where
        P: 'a;

    fn len(&self) -> usize {
        <[P]>::len(self)
    }

    #[inline(always)]
    fn polygon(&self, i: usize) -> &P {
        &self[i]
    }
}

impl<P: Polygon + Sync> Batch for Vec<P> {
    type Polygon<'a>
        = &'a P
    where
        P: 'a;

    fn len(&self) -> usize {
        self.as_slice().len()
    }

    #[inline(always)]
    fn polygon(&self, i: usize) -> &P {
        &self[i]
    }
}

/// Faces of `N` vertices each, out of a shared list: the triangles of a mesh.
#[derive(Debug)]
pub struct Mesh<'a, V: ?Sized, const N: usize> {
    vertices: &'a V,
    faces: &'a [[u32; N]],
    placed: Option<&'a Placed>,
}

impl<'a, V: Polygon + ?Sized, const N: usize> Mesh<'a, V, N> {
    /// Of `faces`, which name vertices by their numbers.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`] for a number that names none; `at` counts over all faces.
    pub fn new(vertices: &'a V, faces: &'a [[u32; N]]) -> Result<Self, Error> {
        Indexed::new(vertices, faces.as_flattened())?;
        Ok(Self { vertices, faces, placed: None })
    }

    /// With the places of all the vertices of the list, so that each is worked out once.
    pub fn with_placed(self, placed: &'a Placed) -> Self {
        Self { placed: Some(placed), ..self }
    }
}

impl<V: Polygon + Sync + ?Sized, const N: usize> Batch for Mesh<'_, V, N> {
    type Polygon<'a>
        = Indexed<'a, V>
    where
        Self: 'a;

    fn len(&self) -> usize {
        self.faces.len()
    }

    #[inline(always)]
    fn polygon(&self, i: usize) -> Indexed<'_, V> {
        Indexed::of_checked(self.vertices, &self.faces[i], self.placed)
    }
}
