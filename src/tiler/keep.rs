//! Set-ups that are kept: a polygon of several bands is clipped, divided and set up once, and not
//! for each of them.

use alloc::vec::Vec;

use super::{Outcome, Scratch, Tiler};
use crate::polygon::Polygon;
use crate::shade::Shader;
use crate::space::PixelRect;
use crate::target::{DepthBuffer, Target};

/// Polygons kept at a time.
const MOST: usize = 512;

/// Slots that are looked at for one that is over.
const LOOKED_AT: usize = 8;

/// The set-ups that one thread keeps.
#[derive(Debug, Default)]
pub(crate) struct Keep {
    slots: Vec<Slot>,
    /// For each polygon its slot, if it has one.
    slot_of: Vec<u32>,
    /// Where the search for a slot goes on.
    hand: usize,
}

/// A polygon that is kept.
#[derive(Debug, Default)]
struct Slot {
    number: u32,
    last_band: u32,
    scratch: Scratch,
    /// Was there anything to draw?
    taken: bool,
}

/// No slot.
const NONE: u32 = u32::MAX;

impl Keep {
    /// Forgets all, for a frame in which `count` polygons may be kept.
    pub(crate) fn reset(&mut self, count: usize) {
        self.slot_of.clear();
        self.slot_of.resize(count, NONE);
        for slot in &mut self.slots {
            (slot.number, slot.last_band) = (NONE, 0);
        }
    }

    /// The slot of polygon `number`, whose last band is `last_band`, in band `band`, and whether it
    /// is in it already; nothing if there is no room.
    fn slot(&mut self, number: u32, last_band: u32, band: u32) -> Option<(&mut Slot, bool)> {
        let at = *self.slot_of.get(number as usize)?;
        if at != NONE {
            return self.slots.get_mut(at as usize).map(|slot| (slot, true));
        }
        let found = self.find(band)?;
        let slot = self.slots.get_mut(found)?;
        if let Some(old) = self.slot_of.get_mut(slot.number as usize) {
            *old = NONE;
        }
        *self.slot_of.get_mut(number as usize)? = u32::try_from(found).unwrap_or(NONE);
        (slot.number, slot.last_band) = (number, last_band);
        Some((slot, false))
    }

    /// A slot whose polygon is over, or a new one.
    fn find(&mut self, band: u32) -> Option<usize> {
        for _ in 0..LOOKED_AT.min(self.slots.len()) {
            self.hand = if self.hand + 1 < self.slots.len() { self.hand + 1 } else { 0 };
            let slot = &self.slots[self.hand];
            if slot.number == NONE || slot.last_band < band {
                return Some(self.hand);
            }
        }
        (self.slots.len() < MOST).then(|| {
            self.slots.push(Slot { number: NONE, ..Slot::default() });
            self.slots.len() - 1
        })
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let scratches: usize = self.slots.iter().map(|slot| slot.scratch.bytes()).sum();
        self.slots.capacity() * size_of::<Slot>()
            + self.slot_of.capacity() * size_of::<u32>()
            + scratches
    }
}

/// A polygon of a draw list that is worth keeping.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    /// Among those that are.
    pub(crate) number: u32,
    pub(crate) last_band: u32,
}

impl Tiler {
    /// Draws `polygon`, of which `kept` says how it is known, in band `band`.
    pub(crate) fn draw_kept<V, S, T>(
        &mut self,
        polygon: &V,
        window: PixelRect,
        (keep, kept, band): (&mut Keep, Kept, u32),
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let Some((slot, is_there)) = keep.slot(kept.number, kept.last_band, band) else {
            self.draw_any(polygon, window, shader, target, depth);
            return;
        };
        core::mem::swap(&mut self.scratch, &mut slot.scratch);
        if !is_there {
            slot.taken = self.take_whole(polygon) == Outcome::Drawn;
        }
        if slot.taken {
            self.draw_taken(polygon, window, shader, target, depth);
        }
        core::mem::swap(&mut self.scratch, &mut slot.scratch);
    }
}
