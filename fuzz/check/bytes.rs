//! From any bytes to choices and numbers, with a bias to what breaks rasterizers: signed zeros,
//! subnormals, giants, NaN, whole numbers of small steps.

/// Reads choices off the input; zeros once it is used up.
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl Bytes<'_> {
    pub(super) fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut out = [0; N];
        let n = N.min(self.0.len());
        out[..n].copy_from_slice(&self.0[..n]);
        self.0 = &self.0[n..];
        out
    }

    pub(super) fn byte(&mut self) -> u8 {
        self.array::<1>()[0]
    }

    pub(super) fn below(&mut self, n: u8) -> u8 {
        self.byte() % n
    }

    pub(super) fn small(&mut self) -> i32 {
        i32::from(self.byte().cast_signed())
    }

    pub(super) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[usize::from(self.byte()) % from.len()]
    }

    /// Any number, often an awkward one.
    pub(super) fn number(&mut self) -> f64 {
        match self.below(8) {
            0 => f64::from(f32::from_bits(u32::from_le_bytes(self.array()))),
            1 => f64::from_bits(u64::from_le_bytes(self.array())),
            2 | 3 => self.pick(&AWKWARD),
            4 => f64::from(self.small()) / 16.0,
            5 => f64::from(i16::from_le_bytes(self.array())) / 4096.0,
            6 => f64::from(self.small()) * 2.0_f64.powi(self.small()),
            _ => 1.0 + f64::from(self.small()) * f64::from(f32::EPSILON),
        }
    }

    pub(super) fn number_f32(&mut self) -> f32 {
        self.number() as f32
    }
}

const AWKWARD: [f64; 32] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2.0,
    3.0,
    1e-3,
    -1e-3,
    1e-9,
    1e9,
    1e20,
    -1e20,
    3e38,
    -3e38,
    1e-40,                  // a subnormal f32
    -1e-40,                 //
    1.401298464324817e-45,  // the least f32
    1.1754943508222875e-38, // the least normal f32
    5e-324,                 // the least f64
    2.2250738585072014e-308,
    1e-300,
    1e300,
    -1e300,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    8.673617379884035e-19, // 2^-60
    1.152921504606847e18,  // 2^60
];
