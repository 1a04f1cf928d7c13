//! Polygons sorted into bands of rows, in the order in which they were submitted.

use alloc::vec::Vec;

use crate::tiler::sort::Rows;

/// Polygons of a call that are sorted at a time: what one thread takes.
pub(crate) const CHUNK: usize = 1 << 13;

/// In an entry, which is a polygon's number in its chunk and this bit: is this the polygon's first band?
const FIRST_BAND: u32 = 1 << 30;

/// What one thread has sorted.
#[derive(Debug, Default)]
pub(crate) struct Bins {
    bands: Vec<Bin>,
    /// The framebuffer row where band 0 begins, and the rows of a band.
    first_row: i32,
    band_rows: u32,
    chunk: u32,
}

/// The polygons of a band.
#[derive(Debug, Default)]
struct Bin {
    words: Vec<u32>,
    runs: Vec<Run>,
}

/// What a chunk has in a band: the words `start..end`.
#[derive(Clone, Copy, Debug)]
struct Run {
    chunk: u32,
    start: u32,
    end: u32,
}

/// A polygon in a band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Entry {
    /// In its chunk.
    pub(crate) polygon: usize,
    pub(crate) is_first_band: bool,
}

impl Bins {
    /// Empties all, for `bands` bands of `band_rows` rows from `first_row` on.
    pub(crate) fn reset(&mut self, bands: usize, first_row: i32, band_rows: u32) {
        if self.bands.len() < bands {
            self.bands.resize_with(bands, Bin::default);
        }
        for bin in &mut self.bands {
            bin.words.clear();
            bin.runs.clear();
        }
        (self.first_row, self.band_rows) = (first_row, band_rows);
    }

    /// What is added from now on is of this chunk.
    pub(crate) fn start_chunk(&mut self, chunk: u32) {
        self.chunk = chunk;
    }

    /// Adds polygon `polygon` of the chunk to the bands of its rows.
    #[inline(always)]
    pub(crate) fn add(&mut self, polygon: usize, rows: Rows) {
        let band_of = |row: i32| row.abs_diff(self.first_row) / self.band_rows;
        let (first, last) = (band_of(rows.first), band_of(rows.last));
        for band in first..=last {
            let bit = if band == first { FIRST_BAND } else { 0 };
            self.push(band, polygon as u32 | bit);
        }
    }

    #[inline(always)]
    fn push(&mut self, band: u32, word: u32) {
        let Some(bin) = self.bands.get_mut(band as usize) else { return };
        let start = bin.words.len() as u32;
        bin.words.push(word);
        let end = bin.words.len() as u32;
        match bin.runs.last_mut() {
            Some(run) if run.chunk == self.chunk => run.end = end,
            _ => bin.runs.push(Run { chunk: self.chunk, start, end }),
        }
    }

    /// A thread takes chunks in any order; from here on they are in theirs.
    pub(crate) fn finish(&mut self) {
        for bin in &mut self.bands {
            bin.runs.sort_unstable_by_key(|run| run.chunk);
        }
    }

    /// Words in band `band`: how much there is to do.
    pub(crate) fn weight(&self, band: usize) -> usize {
        self.bands.get(band).map_or(0, |bin| bin.words.len())
    }

    /// The chunk of run `run` of band `band`, and its polygons.
    pub(crate) fn run(&self, band: usize, run: usize) -> Option<(u32, Entries<'_>)> {
        let bin = self.bands.get(band)?;
        let Run { chunk, start, end } = *bin.runs.get(run)?;
        Some((chunk, Entries { words: bin.words.get(start as usize..end as usize)? }))
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let bins = self.bands.iter().map(|bin| {
            bin.words.capacity() * size_of::<u32>() + bin.runs.capacity() * size_of::<Run>()
        });
        self.bands.capacity() * size_of::<Bin>() + bins.sum::<usize>()
    }
}

/// Polygons of a chunk in a band.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries<'a> {
    words: &'a [u32],
}

impl Iterator for Entries<'_> {
    type Item = Entry;

    #[inline(always)]
    fn next(&mut self) -> Option<Entry> {
        let (&word, rest) = self.words.split_first()?;
        self.words = rest;
        let polygon = (word & !FIRST_BAND) as usize;
        Some(Entry { polygon, is_first_band: word & FIRST_BAND != 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_polygons_in_the_order_of_their_chunks() {
        let mut bins = Bins::default();
        bins.reset(3, -8, 16);
        bins.start_chunk(7);
        bins.add(1, Rows { first: -8, last: 7 });
        bins.add(2, Rows { first: 7, last: 8 });
        bins.start_chunk(3);
        bins.add(5, Rows { first: 0, last: 39 });
        bins.finish();
        let of = |band: usize, run: usize| {
            let (chunk, entries) = bins.run(band, run).expect("a run");
            (chunk, entries.collect::<Vec<_>>())
        };
        let entry = |polygon, is_first_band| Entry { polygon, is_first_band };
        assert_eq!(of(0, 0), (3, [entry(5, true)].to_vec()));
        assert_eq!(of(0, 1), (7, [entry(1, true), entry(2, true)].to_vec()));
        assert_eq!(of(1, 0), (3, [entry(5, false)].to_vec()));
        assert_eq!(of(1, 1), (7, [entry(2, false)].to_vec()));
        assert_eq!(of(2, 0), (3, [entry(5, false)].to_vec()));
        assert!(bins.run(2, 1).is_none());
        assert_eq!((bins.weight(0), bins.weight(2)), (3, 1));
    }
}
