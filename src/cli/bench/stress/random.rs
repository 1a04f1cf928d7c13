//! Numbers that look random and are the same on every machine: splitmix64 (Steele, Lea and Flood
//! 2014).

/// A stream of them.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    /// The stream that belongs to `seed`.
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Self(seed);
        // Streams of neighbouring seeds would be shifted copies of each other.
        Self(random.bits())
    }

    /// 64 bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// 0 to 1, without 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// `least` to `most`.
    pub(crate) fn within(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.unit()
    }

    /// 0 to `count`, without `count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// 1 to `most`, every power of two as often.
    pub(crate) fn up_to(&mut self, most: f64) -> f64 {
        let exponent = most.to_bits() >> 52;
        let powers = (exponent.max(1023) - 1023) as usize + 1;
        let power = f64::from_bits((1023 + self.below(powers) as u64) << 52);
        (power * (1.0 + self.unit())).min(most)
    }

    /// `value` or its negative.
    pub(crate) fn signed(&mut self, value: f64) -> f64 {
        if self.below(2) == 0 { value } else { -value }
    }
}
