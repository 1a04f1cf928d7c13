//! Polygons as they come in: positions in clip space and attributes, however they are kept.
//!
//! A polygon is a closed list of vertices, convex or nearly so, without a repeated first vertex.
//! The tiler reads it through [`Polygon`]; the number of attributes may be a constant
//! ([`Vertex`]) or a variable ([`Strided`]), through the same code. Nothing is copied here,
//! and nothing is judged: refusing a polygon is the clipper's first step.

use alloc::vec::Vec;

use crate::error::Error;
use crate::fetch::fetch;
use crate::placed::Placed;
use crate::space::ClipPosition;

/// A polygon: positions in clip space, and as many attributes at each vertex.
///
/// For your own storage, implement this; vertices are asked for by number, any number of times.
pub trait Polygon {
    /// The number of vertices. Fewer than 3 draw nothing.
    fn len(&self) -> usize;

    /// Has it no vertex?
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of attributes, the same at every vertex; 0 is fine.
    fn attribute_count(&self) -> usize;

    /// (x, y, z, w) of vertex `i`, below `len()`.
    fn position(&self, i: usize) -> [f64; 4];

    /// Attribute `k` (below `attribute_count()`) of vertex `i` (below `len()`).
    fn attribute(&self, i: usize, k: usize) -> f32;

    /// Where the vertices lie, if that has been worked out: for polygons that share them. They
    /// must be those of [`position`](Self::position), else what is drawn is anybody's guess;
    /// those of another viewport than the tiler's are not used.
    #[inline]
    fn placed(&self) -> Option<&Placed> {
        None
    }

    /// The number in [`placed`](Self::placed) of vertex `i`.
    #[inline]
    fn placed_index(&self, i: usize) -> usize {
        i
    }

    /// Vertex `i` (below `len()`) will be read soon: who knows where it lies may ask for its memory. Where it is
    /// [placed](Self::placed) is asked for anyway.
    #[inline]
    fn fetch(&self, _i: usize) {}
}

impl<V: Polygon + ?Sized> Polygon for &V {
    #[inline(always)]
    fn len(&self) -> usize {
        (**self).len()
    }

    #[inline(always)]
    fn attribute_count(&self) -> usize {
        (**self).attribute_count()
    }

    #[inline(always)]
    fn position(&self, i: usize) -> [f64; 4] {
        (**self).position(i)
    }

    #[inline(always)]
    fn attribute(&self, i: usize, k: usize) -> f32 {
        (**self).attribute(i, k)
    }

    #[inline(always)]
    fn placed(&self) -> Option<&Placed> {
        (**self).placed()
    }

    #[inline(always)]
    fn placed_index(&self, i: usize) -> usize {
        (**self).placed_index(i)
    }

    #[inline(always)]
    fn fetch(&self, i: usize) {
        (**self).fetch(i);
    }
}

/// A vertex with `N` attributes. An array, a slice or a `Vec` of them is a [`Polygon`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex<const N: usize, P = [f32; 4]> {
    /// Clip space: (x, y, z, w).
    pub position: P,
    /// Interpolated over the polygon.
    pub attributes: [f32; N],
}

impl<const N: usize, P> Vertex<N, P> {
    /// A vertex from its clip-space position and its attributes.
    pub const fn new(position: P, attributes: [f32; N]) -> Self {
        Self { position, attributes }
    }
}

macro_rules! vertex_list {
    ($list:ty $(, $length:ident)?) => {
        impl<const N: usize, P: ClipPosition $(, const $length: usize)?> Polygon for $list {
            #[inline]
            fn len(&self) -> usize {
                <[_]>::len(self)
            }

            #[inline]
            fn attribute_count(&self) -> usize {
                N
            }

            #[inline]
            fn position(&self, i: usize) -> [f64; 4] {
                self[i].position.to_clip()
            }

            #[inline]
            fn attribute(&self, i: usize, k: usize) -> f32 {
                self[i].attributes[k]
            }

            #[inline]
            fn fetch(&self, i: usize) {
                fetch(self, i);
            }
        }
    };
}

vertex_list!([Vertex<N, P>]);
vertex_list!([Vertex<N, P>; M], M);
vertex_list!(Vec<Vertex<N, P>>);

/// A polygon whose number of attributes is known at run time: positions in one slice,
/// attributes in another, vertex `i`'s at `i * stride ..`.
#[derive(Clone, Copy, Debug)]
pub struct Strided<'a, P> {
    positions: &'a [P],
    attributes: &'a [f32],
    stride: usize,
    count: usize,
}

impl<'a, P: ClipPosition> Strided<'a, P> {
    /// `count` attributes for each position, `stride` apart from one vertex to the next.
    ///
    /// # Errors
    /// [`Error::StrideTooSmall`] if `stride < count`, [`Error::AttributesTooShort`] if the last
    /// vertex's attributes reach beyond the slice.
    pub fn new(
        positions: &'a [P],
        attributes: &'a [f32],
        stride: usize,
        count: usize,
    ) -> Result<Self, Error> {
        if stride < count {
            return Err(Error::StrideTooSmall { needed: count, given: stride });
        }
        let needed = match positions.len() {
            0 => 0,
            n => (n - 1).saturating_mul(stride).saturating_add(count),
        };
        if attributes.len() < needed {
            return Err(Error::AttributesTooShort { needed, given: attributes.len() });
        }
        Ok(Self { positions, attributes, stride, count })
    }
}

impl<P: ClipPosition> Polygon for Strided<'_, P> {
    #[inline]
    fn len(&self) -> usize {
        self.positions.len()
    }

    #[inline]
    fn attribute_count(&self) -> usize {
        self.count
    }

    #[inline]
    fn position(&self, i: usize) -> [f64; 4] {
        self.positions[i].to_clip()
    }

    #[inline]
    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.attributes[i * self.stride + k]
    }

    #[inline]
    fn fetch(&self, i: usize) {
        fetch(self.positions, i);
        fetch(self.attributes, i.wrapping_mul(self.stride));
    }
}

/// A polygon that picks its vertices out of a shared list.
#[derive(Debug)]
pub struct Indexed<'a, V: ?Sized> {
    vertices: &'a V,
    indices: &'a [u32],
    placed: Option<&'a Placed>,
}

impl<'a, V: Polygon + ?Sized> Indexed<'a, V> {
    /// The polygon of `vertices[indices[0]]`, `vertices[indices[1]]`, and so on.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`] for an index that names no vertex.
    pub fn new(vertices: &'a V, indices: &'a [u32]) -> Result<Self, Error> {
        let n = vertices.len();
        match indices.iter().position(|i| *i as usize >= n) {
            Some(at) => Err(Error::IndexOutOfRange { at, index: indices[at], vertices: n }),
            None => Ok(Self { vertices, indices, placed: None }),
        }
    }
}

impl<'a, V: ?Sized> Indexed<'a, V> {
    /// The same of indices that are known to name vertices.
    #[inline(always)]
    pub(crate) fn of_checked(
        vertices: &'a V,
        indices: &'a [u32],
        placed: Option<&'a Placed>,
    ) -> Self {
        Self { vertices, indices, placed }
    }

    /// With the places of all the vertices of the list.
    pub fn with_placed(self, placed: &'a Placed) -> Self {
        Self { placed: Some(placed), ..self }
    }
}

impl<V: Polygon + ?Sized> Polygon for Indexed<'_, V> {
    #[inline]
    fn len(&self) -> usize {
        self.indices.len()
    }

    #[inline]
    fn attribute_count(&self) -> usize {
        self.vertices.attribute_count()
    }

    #[inline]
    fn position(&self, i: usize) -> [f64; 4] {
        self.vertices.position(self.indices[i] as usize)
    }

    #[inline]
    fn attribute(&self, i: usize, k: usize) -> f32 {
        self.vertices.attribute(self.indices[i] as usize, k)
    }

    #[inline]
    fn placed(&self) -> Option<&Placed> {
        self.placed
    }

    #[inline]
    fn placed_index(&self, i: usize) -> usize {
        self.indices[i] as usize
    }

    #[inline]
    fn fetch(&self, i: usize) {
        self.vertices.fetch(self.indices[i] as usize);
    }
}
