//! What a frame is drawn into: the picture, the depth buffer, and a plane for each kind of data
//! that was asked for. How they are filled is in `shaders.rs`. They are drawn in bands of rows.

use std::sync::Mutex;

use hyperspan::Aligned;
use hyperspan::depth::DepthBounds;
use hyperspan::draw;
use hyperspan::target::DepthBuffer;

use crate::aov::Aov;
use crate::failure::Failure;
use crate::flags::Crop;
use crate::memory;
use crate::progress::Progress;
use crate::shaders::plane;

/// The values of a plane, pixel after pixel.
#[derive(Debug)]
pub(crate) enum Values {
    /// Measures.
    Floats(Aligned<f32>),
    /// Numbers and counts.
    Integers(Aligned<u32>),
}

/// One kind of data, for all pixels of the crop.
#[derive(Debug)]
pub(crate) struct DataPlane {
    /// What it holds.
    pub(crate) aov: Aov,
    /// Values for each pixel.
    pub(crate) channels: usize,
    /// `channels` of them for each pixel, row 0 on top.
    pub(crate) values: Values,
}

impl DataPlane {
    fn new(aov: Aov, pixels: usize, attributes: usize) -> Result<Self, Failure> {
        let channels = aov.channels(attributes).unwrap_or(1);
        let count = pixels.saturating_mul(channels);
        let values = match aov {
            Aov::Id | Aov::Overdraw => Values::Integers(memory::filled(count, 0)?),
            _ => Values::Floats(memory::filled(count, 0.0)?),
        };
        Ok(Self { aov, channels, values })
    }

    /// All of it, to be drawn.
    fn rows(&mut self) -> PlaneRows<'_> {
        let values = match &mut self.values {
            Values::Floats(values) => RowValues::Floats(values),
            Values::Integers(values) => RowValues::Integers(values),
        };
        PlaneRows { aov: self.aov, channels: self.channels, values }
    }
}

/// What is to be drawn.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    /// The rectangle of the framebuffer.
    pub(crate) crop: Crop,
    /// Is a picture wanted, and on which background?
    pub(crate) picture: Option<[u8; 4]>,
    /// Is there a depth buffer?
    pub(crate) depth_buffer: bool,
    /// What depth is where nothing is drawn.
    pub(crate) clear_depth: f32,
    /// The data wanted; the same one twice is drawn once.
    pub(crate) aovs: &'a [Aov],
    /// Attributes of a polygon, for [`Aov::Attr`].
    pub(crate) attributes: usize,
}

/// All that a frame is drawn into: of the size of the crop, which begins at its first pixel.
#[derive(Debug)]
pub(crate) struct Canvas {
    /// Which part of the framebuffer this is.
    pub(crate) crop: Crop,
    background: [u8; 4],
    clear_depth: f32,
    /// RGBA8, or nothing if no picture is wanted.
    pub(crate) picture: Option<Aligned<[u8; 4]>>,
    /// The depth buffer, or nothing if there is no test. It is the depth that is written to
    /// files too.
    pub(crate) depth: Option<Aligned<f32>>,
    /// Of the depth buffer.
    bounds: DepthBounds,
    /// What [`Data`](crate::shaders::Data) fills.
    planes: Vec<DataPlane>,
    /// What the pass without depth test fills.
    overdraw: Option<DataPlane>,
}

impl Canvas {
    /// Memory for all of `plan`.
    pub(crate) fn new(plan: &Plan<'_>) -> Result<Self, Failure> {
        let crop = plan.crop;
        let pixels = crop.width as usize * crop.height as usize;
        let mut aovs = Vec::new();
        for aov in plan.aovs {
            if !aovs.contains(aov) {
                aovs.push(*aov);
            }
        }
        let values: usize =
            aovs.iter().map(|aov| aov.channels(plan.attributes).unwrap_or(1)).sum::<usize>()
                + usize::from(plan.picture.is_some())
                + usize::from(plan.depth_buffer);
        memory::check((pixels as u64).saturating_mul(values as u64).saturating_mul(4))?;

        // The depth buffer doubles as the data.
        aovs.retain(|aov| !(*aov == Aov::Depth && plan.depth_buffer));
        let (overdraw, shaded): (Vec<_>, Vec<_>) =
            aovs.into_iter().partition(|aov| *aov == Aov::Overdraw);
        let plane = |aov| DataPlane::new(aov, pixels, plan.attributes);
        Ok(Self {
            crop,
            background: plan.picture.unwrap_or_default(),
            clear_depth: plan.clear_depth,
            picture: plan.picture.map(|color| memory::filled(pixels, color)).transpose()?,
            depth: plan
                .depth_buffer
                .then(|| memory::filled(pixels, plan.clear_depth))
                .transpose()?,
            bounds: DepthBounds::new(),
            planes: shaded.into_iter().map(plane).collect::<Result<_, _>>()?,
            overdraw: overdraw.into_iter().map(plane).next().transpose()?,
        })
    }

    /// Must pixels go through [`Data`](crate::shaders::Data)?
    pub(crate) fn has_data(&self) -> bool {
        !self.planes.is_empty()
    }

    /// Is there a plane of depth or w among them? A depth buffer is none.
    pub(crate) fn has_depth_or_w(&self) -> bool {
        self.wants(Aov::Depth) || self.wants(Aov::W)
    }

    /// Does a pixel's colour matter?
    pub(crate) fn has_color(&self) -> bool {
        self.picture.is_some() || self.wants(Aov::Color)
    }

    /// Is `aov` among what [`Data`](crate::shaders::Data) fills?
    pub(crate) fn wants(&self, aov: Aov) -> bool {
        self.planes.iter().any(|plane| plane.aov == aov)
    }

    /// All rows, to be drawn; `meter` is told how far that is.
    pub(crate) fn band<'a>(&'a mut self, meter: &'a Meter<'a>) -> Band<'a> {
        Band {
            crop: self.crop,
            background: self.background,
            clear_depth: self.clear_depth,
            picture: self.picture.as_deref_mut(),
            depth: self
                .depth
                .as_deref_mut()
                .map(|depth| plane(depth, self.crop).with_bounds(&mut self.bounds)),
            planes: self.planes.iter_mut().map(DataPlane::rows).collect(),
            meter,
        }
    }

    /// What counts how often each pixel is covered, if that is wanted. It goes with a pass
    /// without depth test.
    pub(crate) fn overdraw(&mut self) -> Option<Counts<'_>> {
        match &mut self.overdraw.as_mut()?.values {
            Values::Integers(counts) => Some(Counts { crop: self.crop, counts }),
            Values::Floats(_) => None,
        }
    }

    /// What was drawn of `aov`: values, and how many there are for each pixel. The depth
    /// buffer is asked too.
    pub(crate) fn data(&self, aov: Aov) -> Option<Drawn<'_>> {
        if let (Aov::Depth, Some(depth)) = (aov, &self.depth) {
            return Some(Drawn::Floats { values: depth, channels: 1 });
        }
        let plane = self.planes.iter().chain(&self.overdraw).find(|plane| plane.aov == aov)?;
        Some(match &plane.values {
            Values::Floats(values) => Drawn::Floats { values, channels: plane.channels },
            Values::Integers(values) => Drawn::Integers { values },
        })
    }
}

/// The values of one kind of data.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Drawn<'a> {
    /// `channels` for each pixel.
    Floats {
        /// Pixel after pixel.
        values: &'a [f32],
        /// Values for each pixel.
        channels: usize,
    },
    /// One for each pixel.
    Integers {
        /// Pixel after pixel.
        values: &'a [u32],
    },
}

/// Tells of the rows that have been begun.
#[derive(Debug)]
pub(crate) struct Meter<'a> {
    progress: Mutex<(&'a mut Progress, u64)>,
    rows: u64,
}

impl<'a> Meter<'a> {
    /// Of `rows` rows.
    pub(crate) fn new(progress: &'a mut Progress, rows: u32) -> Self {
        Self { progress: Mutex::new((progress, 0)), rows: rows.into() }
    }

    fn add(&self, rows: u32) {
        if let Ok(mut progress) = self.progress.lock() {
            progress.1 += u64::from(rows);
            let done = progress.1;
            progress.0.set(done, self.rows);
        }
    }
}

/// Some rows of a canvas.
#[derive(Debug)]
pub(crate) struct Band<'a> {
    /// Which pixels of the framebuffer they are.
    pub(crate) crop: Crop,
    pub(crate) background: [u8; 4],
    clear_depth: f32,
    /// RGBA8, if a picture is wanted.
    pub(crate) picture: Option<&'a mut [[u8; 4]]>,
    /// Depths, if there is a test.
    pub(crate) depth: Option<DepthBuffer<'a>>,
    /// One for each kind of data.
    pub(crate) planes: Vec<PlaneRows<'a>>,
    meter: &'a Meter<'a>,
}

/// Some rows of one kind of data.
#[derive(Debug)]
pub(crate) struct PlaneRows<'a> {
    /// What it holds.
    pub(crate) aov: Aov,
    /// Values for each pixel.
    pub(crate) channels: usize,
    /// Pixel after pixel.
    pub(crate) values: RowValues<'a>,
}

/// The values of some rows.
#[derive(Debug)]
pub(crate) enum RowValues<'a> {
    /// Measures.
    Floats(&'a mut [f32]),
    /// Numbers and counts.
    Integers(&'a mut [u32]),
}

impl<'a> PlaneRows<'a> {
    fn split_at_pixel(self, pixel: usize) -> (Self, Self) {
        let Self { aov, channels, values } = self;
        let at = pixel * channels;
        let (above, below) = match values {
            RowValues::Floats(values) => {
                let (above, below) = values.split_at_mut(at);
                (RowValues::Floats(above), RowValues::Floats(below))
            }
            RowValues::Integers(values) => {
                let (above, below) = values.split_at_mut(at);
                (RowValues::Integers(above), RowValues::Integers(below))
            }
        };
        (Self { aov, channels, values: above }, Self { aov, channels, values: below })
    }

    fn clear(&mut self, depth: f32) {
        match (&mut self.values, self.aov) {
            (RowValues::Floats(values), Aov::Depth) => values.fill(depth),
            (RowValues::Floats(values), _) => values.fill(0.0),
            (RowValues::Integers(values), Aov::Id) => values.fill(u32::MAX),
            (RowValues::Integers(values), _) => values.fill(0),
        }
    }
}

impl Crop {
    /// The rows above `row`, and the others.
    fn split_at_row(self, row: u32) -> (Self, Self) {
        let below = Self { y: self.y + row, height: self.height - row, ..self };
        (Self { height: row, ..self }, below)
    }

    fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// Both parts of what may be there.
fn split<T>(slice: Option<&mut [T]>, at: usize) -> (Option<&mut [T]>, Option<&mut [T]>) {
    match slice.map(|slice| slice.split_at_mut(at)) {
        Some((above, below)) => (Some(above), Some(below)),
        None => (None, None),
    }
}

impl draw::Canvas for Band<'_> {
    fn size(&self) -> (u32, u32) {
        (self.crop.width, self.crop.height)
    }

    fn split_at_row(self, row: u32) -> (Self, Self) {
        let (crop, crop_below) = self.crop.split_at_row(row);
        let at = crop.pixels();
        let (picture, picture_below) = split(self.picture, at);
        let (depth, depth_below) = self.depth.map(|depth| depth.split_at_row(row)).unzip();
        let planes = self.planes.into_iter().map(|plane| plane.split_at_pixel(at));
        let (planes, planes_below) = planes.unzip();
        let Self { background, clear_depth, meter, .. } = self;
        (
            Self { crop, background, clear_depth, picture, depth, planes, meter },
            Self {
                crop: crop_below,
                background,
                clear_depth,
                picture: picture_below,
                depth: depth_below,
                planes: planes_below,
                meter,
            },
        )
    }

    fn clear(&mut self) {
        self.meter.add(self.crop.height);
        if let Some(picture) = &mut self.picture {
            plane(picture, self.crop).clear(self.background);
        }
        if let Some(depth) = &mut self.depth {
            depth.clear(self.clear_depth);
        }
        for plane in &mut self.planes {
            plane.clear(self.clear_depth);
        }
    }

    fn clear_later(&mut self) -> bool {
        let Some(depth) = self.depth.as_mut().filter(|_| self.planes.is_empty()) else {
            return false;
        };
        let later = depth.clear_later(self.clear_depth);
        if later {
            self.meter.add(self.crop.height);
        }
        later
    }
}

/// How often the pixels of some rows are covered.
#[derive(Debug)]
pub(crate) struct Counts<'a> {
    /// Which pixels of the framebuffer they are.
    pub(crate) crop: Crop,
    /// Row after row.
    pub(crate) counts: &'a mut [u32],
}

impl draw::Canvas for Counts<'_> {
    fn size(&self) -> (u32, u32) {
        (self.crop.width, self.crop.height)
    }

    fn split_at_row(self, row: u32) -> (Self, Self) {
        let (crop, crop_below) = self.crop.split_at_row(row);
        let (counts, counts_below) = self.counts.split_at_mut(crop.pixels());
        (Self { crop, counts }, Self { crop: crop_below, counts: counts_below })
    }

    fn clear(&mut self) {
        self.counts.fill(0);
    }
}
