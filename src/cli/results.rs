//! From a canvas to files: what `render` and `tile` do once everything is drawn.

use crate::aov::{Format, Request};
use crate::canvas::{Canvas, Drawn};
use crate::failure::Failure;
use crate::flags::{DrawFlags, Sink};
use crate::frames::Timings;
use crate::output::{Staged, check_place, write_data_png, write_npy, write_rgba_png};

/// Says early what can be known to go wrong with the files that are asked for.
pub(crate) fn check(flags: &DrawFlags, aovs: &[Request]) -> Result<(), Failure> {
    flags.check(aovs.len())?;
    let sinks = [&flags.output, &flags.stats].into_iter().flatten();
    let files = sinks.filter_map(|sink| match sink {
        Sink::Stdout => None,
        Sink::File(path) => Some(path),
    });
    files.chain(aovs.iter().map(|request| &request.path)).try_for_each(|path| check_place(path))
}

/// Writes the picture, the data and the counts that are asked for: all of them, or none.
pub(crate) fn write(
    flags: &DrawFlags,
    aovs: &[Request],
    canvas: &Canvas,
    timings: &Timings,
) -> Result<(), Failure> {
    let mut staged = Staged::default();
    let (width, height) = (canvas.crop.width, canvas.crop.height);
    if let (Some(sink), Some(picture)) = (&flags.output, &canvas.picture) {
        staged.add(sink, |out| write_rgba_png(out, picture, width, height))?;
    }
    for Request { aov, path, format } in aovs {
        let Some(data) = canvas.data(*aov) else { continue };
        let sink = Sink::File(path.clone());
        staged.add(&sink, |out| match format {
            Format::Png => write_data_png(out, *aov, data, width, height),
            Format::Npy => {
                let written = match data {
                    Drawn::Floats { values, channels } => {
                        let has_axis = aov.channels(channels).is_some();
                        let shape = [height as usize, width as usize, channels];
                        let shape = if has_axis { &shape[..] } else { &shape[..2] };
                        let words = values.iter().map(|value| value.to_le_bytes());
                        write_npy(out, "<f4", shape, words)
                    }
                    Drawn::Integers { values } => {
                        let words = values.iter().map(|value| value.to_le_bytes());
                        write_npy(out, "<u4", &[height as usize, width as usize], words)
                    }
                };
                written.map_err(|e| Failure::io(path, "write", &e))
            }
        })?;
    }
    if let Some(sink) = &flags.stats {
        let json = timings.json(flags);
        staged.add(sink, |out| {
            out.write_all(json.as_bytes())
                .map_err(|e| Failure::new(format!("cannot write the counts: {e}")))
        })?;
    }
    staged.commit()
}
