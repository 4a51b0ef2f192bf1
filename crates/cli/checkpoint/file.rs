//! Format of checkpoints and parts: safetensors with text metadata, planes for inspection, the complete state, and a
//! checksum of all of it.

use dapple_integrator::camera::Film;
use safetensors::tensor::{Dtype, TensorView};
use safetensors::{SafeTensors, serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, HashMap};

/// Version of the format.
pub const VERSION: &str = "1";

/// Kinds of files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// The state of a render, which can be resumed.
    #[default]
    Checkpoint,
    /// A part of a render, which can be merged with others.
    Part,
}

impl Kind {
    /// Metadata key of the version of the format.
    fn key(self) -> &'static str {
        match self {
            Self::Checkpoint => "dapple-checkpoint",
            Self::Part => "dapple-part",
        }
    }

    /// The error of a file that lacks the key.
    fn missing(self) -> &'static str {
        match self {
            Self::Checkpoint => "it is not a checkpoint of this program",
            Self::Part => {
                "it is not a part of a render of this program; write one with dapple render -o NAME.part"
            }
        }
    }
}

/// Metadata key of the checksum of everything else.
const CHECKSUM: &str = "sha256";

/// Names of the tensors: the mean and the sample count of each pixel, and the encoded state of the render.
const MEAN: &str = "mean";
const SAMPLES: &str = "samples";
const STATE: &str = "state";

/// Contents of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// What the checkpoint belongs to, by key.
    pub about: BTreeMap<String, String>,
    /// Width and height of the planes in pixels.
    pub size: [usize; 2],
    /// Mean radiance of the pixels, three channels each, row by row from the top left.
    pub mean: Vec<f32>,
    /// Sample counts of the pixels.
    pub samples: Vec<u64>,
    /// The encoded state.
    pub state: Vec<u8>,
}

impl Contents {
    /// The contents of a file for an image whose state is encoded in `state`.
    pub fn of(film: &Film, about: BTreeMap<String, String>, state: Vec<u8>) -> Self {
        let (rect, image) = (film.rect(), film.mean());
        let pixels = (rect.y0..rect.y1).flat_map(|y| (rect.x0..rect.x1).map(move |x| (x, y)));
        Self {
            about,
            size: [rect.width() as usize, rect.height() as usize],
            mean: image.pixels.iter().flat_map(|pixel| pixel.to_array()).collect(),
            samples: pixels.map(|(x, y)| film.count(x, y)).collect(),
            state,
        }
    }

    /// Encodes the file.
    pub fn encode(&self, kind: Kind) -> Result<Vec<u8>, String> {
        let [width, height] = self.size;
        let mean: Vec<u8> = self.mean.iter().flat_map(|x| x.to_le_bytes()).collect();
        let samples: Vec<u8> = self.samples.iter().flat_map(|n| n.to_le_bytes()).collect();
        let mut about: BTreeMap<String, String> = self.about.clone();
        about.insert(kind.key().into(), VERSION.into());
        let parts = [(MEAN, &mean[..]), (SAMPLES, &samples), (STATE, &self.state)];
        about.insert(CHECKSUM.into(), checksum(&about, &parts));
        let view = |dtype, shape, bytes| TensorView::new(dtype, shape, bytes).map_err(|e| e.to_string());
        let tensors = [
            (MEAN, view(Dtype::F32, vec![height, width, 3], &mean)?),
            (SAMPLES, view(Dtype::U64, vec![height, width], &samples)?),
            (STATE, view(Dtype::U8, vec![self.state.len()], &self.state)?),
        ];
        let about: HashMap<String, String> = about.into_iter().collect();
        serialize(tensors, Some(about)).map_err(|e| e.to_string())
    }

    /// Decodes a file; the error says what is wrong with it.
    pub fn decode(kind: Kind, bytes: &[u8]) -> Result<Self, String> {
        let damaged = "it is damaged; use an older copy, or render again";
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|_| damaged)?;
        let mut about: BTreeMap<String, String> =
            header.metadata().iter().flatten().map(|(key, value)| (key.clone(), value.clone())).collect();
        let found = about.remove(CHECKSUM);
        match about.get(kind.key()).map(String::as_str) {
            Some(VERSION) => {}
            Some(version) => {
                let version = crate::error::short(version);
                return Err(format!(
                    "its format is version {version}, and this program reads version {VERSION}"
                ));
            }
            None => return Err(kind.missing().into()),
        }
        let tensors = SafeTensors::deserialize(bytes).map_err(|_| damaged)?;
        let part = |name| tensors.tensor(name).map_err(|_| damaged);
        let (mean, samples, state) = (part(MEAN)?, part(SAMPLES)?, part(STATE)?);
        let parts = [(MEAN, mean.data()), (SAMPLES, samples.data()), (STATE, state.data())];
        let [height, width] = *samples.shape() else { return Err(damaged.into()) };
        let is_whole = found == Some(checksum(&about, &parts))
            && mean.shape() == [height, width, 3]
            && [mean.dtype(), samples.dtype(), state.dtype()] == [Dtype::F32, Dtype::U64, Dtype::U8];
        if !is_whole {
            return Err(damaged.into());
        }
        about.remove(kind.key());
        Ok(Self {
            about,
            size: [width, height],
            mean: mean.data().as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect(),
            samples: samples.data().as_chunks().0.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect(),
            state: state.data().to_vec(),
        })
    }
}

/// Checksum of the metadata and the tensors, each with its length, so that no two contents are encoded alike.
fn checksum(about: &BTreeMap<String, String>, parts: &[(&str, &[u8])]) -> String {
    let mut hash = Sha256::new();
    let mut add = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    for (key, value) in about {
        add(key.as_bytes());
        add(value.as_bytes());
    }
    for (name, bytes) in parts {
        add(name.as_bytes());
        add(bytes);
    }
    hex(&hash.finalize())
}

/// Writes bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contents() -> Contents {
        Contents {
            about: BTreeMap::from([
                ("settings".into(), "spp = 3\nseed = 0".into()),
                ("bits".into(), "3".into()),
            ]),
            size: [2, 1],
            mean: vec![0.5, -0.0, 1e30, f32::NAN, 0.0, 1.0],
            samples: vec![7, u64::MAX],
            state: (0..=255).collect(),
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let (written, bytes) = (contents(), contents().encode(Kind::Part).unwrap());
        let read = Contents::decode(Kind::Part, &bytes).unwrap();
        let bits = |of: &Contents| of.mean.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read), bits(&written));
        let plain = |of: Contents| Contents { mean: Vec::new(), ..of };
        assert_eq!(plain(read), plain(written));
    }

    /// Any flipped bit either is found or changes nothing, as in the padding of the header.
    #[test]
    fn no_flipped_bit_goes_unnoticed() {
        let (bytes, whole) = (contents().encode(Kind::Part).unwrap(), format!("{:?}", contents()));
        let mut found = 0;
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            match Contents::decode(Kind::Part, &flipped) {
                Ok(read) => assert_eq!(format!("{read:?}"), whole, "bit {bit}"),
                Err(_) => found += 1,
            }
        }
        assert!(found > 8 * bytes.len() * 9 / 10, "{found}");
    }

    #[test]
    fn kinds_are_told_apart() {
        let said = Contents::decode(Kind::Checkpoint, &contents().encode(Kind::Part).unwrap());
        assert_eq!(said.unwrap_err(), "it is not a checkpoint of this program");
    }

    #[test]
    fn no_truncated_file_is_read() {
        let bytes = contents().encode(Kind::Part).unwrap();
        assert!((0..bytes.len()).all(|length| Contents::decode(Kind::Part, &bytes[..length]).is_err()));
        let mut longer = bytes;
        longer.push(0);
        assert!(Contents::decode(Kind::Part, &longer).is_err());
    }
}
