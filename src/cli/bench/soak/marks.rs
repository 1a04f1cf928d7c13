//! A polygon alone, of which only the coverage is looked at: a byte for each pixel, row by row
//! against the oracle, so that thousands of millions can be had.

use hyperspan::shade::Solid;
use hyperspan::target::Plane;
use rayon::ThreadPool;

use super::check::{Tally, Wrong, run};
use super::outline::{Outline, Span};
use super::scene::Scene;

/// Marks that are kept from polygon to polygon.
#[derive(Debug, Default)]
pub(crate) struct Marks {
    /// All 0 between polygons.
    pub(crate) drawn: Vec<u8>,
    /// A row of 0 and one of 1.
    zeros: Vec<u8>,
    ones: Vec<u8>,
    spans: Vec<Span>,
}

impl Marks {
    /// Draws the scene's only piece, which has the outline `outline`.
    pub(crate) fn draw(&mut self, scene: &Scene, pool: &ThreadPool) -> Result<u64, Wrong> {
        let (width, height) = scene.size();
        let size = width as usize * height as usize;
        if self.drawn.len() < size {
            self.drawn.resize(size, 0);
        }
        if self.ones.len() < width as usize {
            self.zeros.resize(width as usize, 0);
            self.ones.resize(width as usize, 1);
        }
        let target = Plane::new(&mut self.drawn, width, height)?;
        Ok(run(scene, target, Solid(1), None, pool).pixels_covered)
    }

    /// Compares what was drawn, and wipes it out.
    pub(crate) fn compare(
        &mut self,
        scene: &Scene,
        outline: &Outline,
        counted: u64,
        tally: &mut Tally,
    ) -> Result<(), Wrong> {
        let (window, visible) = (scene.window, scene.visible());
        let width = scene.size().0 as usize;
        let (mut covered, mut wrong) = (0, None);
        for (y, row) in (window.y0..window.y1).zip(self.drawn.chunks_exact_mut(width)) {
            self.spans.clear();
            if visible.y0 <= y && y < visible.y1 {
                outline.row(y, &mut self.spans);
            }
            let mut at = 0;
            for [start, end] in &self.spans {
                let [start, end] =
                    [*start, *end].map(|x| (x.clamp(visible.x0, visible.x1) - window.x0) as usize);
                let (before, inside) = (&row[at..start], &row[start..end]);
                if before != &self.zeros[..start - at] || inside != &self.ones[..end - start] {
                    wrong = wrong.or(Some(y));
                }
                row[start..end].fill(0);
                covered += (end - start) as u64;
                at = end;
            }
            if row[at..] != self.zeros[at..width] {
                wrong = wrong.or(Some(y));
            }
        }
        if let Some(y) = wrong {
            self.drawn.fill(0);
            return Err(Wrong::new(0, format!("row {y} is not as it must be")));
        }
        if covered != counted {
            return Err(Wrong::new(0, format!("{counted} pixels are drawn, not {covered}")));
        }
        tally.pixels += width as u64 * u64::from(scene.size().1);
        tally.covered += covered;
        Ok(())
    }
}
