//! Orders to draw a batch in: the painter's, and its reverse.
//!
//! By whole polygons, so what intersects, or overlaps in a circle, has no right order without a
//! depth buffer.

use alloc::vec::Vec;

use crate::batch::Batch;
use crate::polygon::Polygon;

/// An order of a batch's polygons. Keep it: a later frame of as many polygons allocates nothing.
///
/// The parts of a face stay together, and faces as far as each other in the order in which they were
/// submitted. Takes O(n log n) comparisons, and 20 bytes for each polygon. Polygons beyond
/// the first 2^32 - 1 are left out.
#[derive(Clone, Debug, Default)]
pub struct DrawOrder {
    faces: Vec<Face>,
    order: Vec<u32>,
}

/// The polygons `first..end`, and how far they are.
#[derive(Clone, Copy, Debug)]
struct Face {
    w: f64,
    first: u32,
    end: u32,
}

impl DrawOrder {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The farthest first, by the greatest w of a face's vertices: the painter's algorithm, for
    /// drawing without a depth buffer.
    pub fn back_to_front<B: Batch>(&mut self, batch: B) -> Ordered<'_, B> {
        self.take(&batch, |a, b| if b > a { b } else { a });
        self.faces.sort_unstable_by(|a, b| b.w.total_cmp(&a.w).then(a.first.cmp(&b.first)));
        self.ordered(batch)
    }

    /// The nearest first, by the least w of a face's vertices: with a depth test what is hidden is
    /// found sooner. Where depths are equal another polygon may be kept than in the order of
    /// submission.
    pub fn front_to_back<B: Batch>(&mut self, batch: B) -> Ordered<'_, B> {
        self.take(&batch, |a, b| if b < a { b } else { a });
        self.faces.sort_unstable_by(|a, b| a.w.total_cmp(&b.w).then(a.first.cmp(&b.first)));
        self.ordered(batch)
    }

    /// Takes the faces of `batch`, each as far as that of its vertices which `which` chooses, of two w
    /// one.
    fn take<B: Batch>(&mut self, batch: &B, which: impl Fn(f64, f64) -> f64) {
        self.faces.clear();
        for i in 0..u32::try_from(batch.len()).unwrap_or(u32::MAX) {
            let polygon = batch.polygon(i as usize);
            let ws = (0..polygon.len()).map(|vertex| polygon.position(vertex)[3]);
            match self.faces.last_mut() {
                Some(face) if batch.continues(i as usize) => {
                    (face.w, face.end) = (ws.fold(face.w, &which), i + 1);
                }
                _ => {
                    let w = ws.reduce(&which).unwrap_or(0.0);
                    self.faces.push(Face { w, first: i, end: i + 1 });
                }
            }
        }
    }

    fn ordered<B: Batch>(&mut self, batch: B) -> Ordered<'_, B> {
        self.order.clear();
        self.order.extend(self.faces.iter().flat_map(|face| face.first..face.end));
        Ordered { batch, order: &self.order }
    }
}

/// A batch in another order.
#[derive(Clone, Copy, Debug)]
pub struct Ordered<'a, B> {
    batch: B,
    order: &'a [u32],
}

impl<B: Batch> Ordered<'_, B> {
    /// Which polygon of the batch comes as number `i`, which is what
    /// [`Shader::start`](crate::shade::Shader::start) is told; `i` itself if there are not so many.
    #[inline(always)]
    pub fn original(&self, i: usize) -> usize {
        self.order.get(i).map_or(i, |i| *i as usize)
    }
}

impl<B: Batch> Batch for Ordered<'_, B> {
    type Polygon<'a>
        = B::Polygon<'a>
    where
        Self: 'a;

    fn len(&self) -> usize {
        self.order.len()
    }

    #[inline(always)]
    fn polygon(&self, i: usize) -> B::Polygon<'_> {
        self.batch.polygon(self.original(i))
    }

    #[inline(always)]
    fn continues(&self, i: usize) -> bool {
        self.batch.continues(self.original(i))
    }
}
