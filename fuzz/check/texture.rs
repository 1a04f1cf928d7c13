//! Texture lookups, with textures of 1 to 300 texels a side and coordinates of any bits. Nothing
//! panics, and:
//!
//! - a texture is made if and only if there are as many texels as its sides say, at least one;
//! - a lookup is the texel that the definition names: column floor(u W) mod W, row floor(v H) mod H
//!   from the bottom, the products in `f32`, in whole numbers from there; (0, 0) where a product is
//!   NaN or not below 2^31;
//! - a block gives each lane of any mask what it has alone.

use hyperspan::shade::BLOCK;
use hyperspan::texture::Texture;

use super::bytes::Bytes;

pub(crate) fn texture(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let side = |bytes: &mut Bytes<'_>| match bytes.below(4) {
        0 => 1 << bytes.below(9),
        1 => u32::from(u16::from_le_bytes(bytes.array())) % 301,
        2 => bytes.pick(&[0, 1, 2, 3, 63, 64, 65, 127, 128, 129, 255, 256, 257]),
        _ => 1 + u32::from(bytes.below(8)),
    };
    let [width, height] = [side(bytes), side(bytes)];
    let square = bytes.below(3) == 0;
    let height = if square { width } else { height };
    let texels: Vec<[u8; 4]> = (0..width * height).map(u32::to_le_bytes).collect();
    check_sizes(bytes, &texels, [width, height]);
    let Ok(texture) = Texture::new(width, height, &texels) else {
        assert_eq!(width * height, 0, "no texture of {width} x {height}");
        return;
    };
    assert_eq!(texture.size(), (width, height));

    let mut coordinates = [[0.0_f32; BLOCK]; 2];
    for (axis, side) in [(0, width), (1, height)] {
        for lane in 0..BLOCK {
            coordinates[axis][lane] = coordinate(bytes, side, &coordinates[axis][..lane]);
        }
    }
    let [u, v] = coordinates;
    let mask = u16::from_le_bytes(bytes.array());
    let mut block = [[0xAB; 4]; BLOCK];
    texture.nearest_block(&u, &v, mask, &mut block);
    for lane in 0..BLOCK {
        let right = right(&texels, [width, height], [u[lane], v[lane]]);
        let found = texture.nearest(u[lane], v[lane]);
        assert_eq!(found, right, "texel at {:e}, {:e} of {width} x {height}", u[lane], v[lane]);
        if mask >> lane & 1 != 0 {
            assert_eq!(
                block[lane], right,
                "lane {lane} of {mask:#x} at {:e}, {:e}",
                u[lane], v[lane]
            );
        }
    }
}

/// Other numbers of texels are refused.
fn check_sizes(bytes: &mut Bytes<'_>, texels: &[[u8; 4]], [width, height]: [u32; 2]) {
    let sides = [
        [width + 1, height],
        [width, height + 1],
        [width.wrapping_sub(1), height],
        [u32::MAX, u32::from(bytes.byte())],
        [1 << 31, 2],
    ];
    for [w, h] in sides {
        let fits = u64::from(w) * u64::from(h) == texels.len() as u64 && !texels.is_empty();
        assert_eq!(Texture::new(w, h, texels).is_ok(), fits, "{} as {w} x {h}", texels.len());
    }
}

/// Near borders between texels, near where `f32` has no fraction and where `i32` ends, the same
/// as before, or any bits.
fn coordinate(bytes: &mut Bytes<'_>, side: u32, before: &[f32]) -> f32 {
    let side = side as f32;
    let near = |bytes: &mut Bytes<'_>, value: f32| {
        f32::from_bits(value.to_bits().wrapping_add_signed(bytes.small() / 16))
    };
    match bytes.below(8) {
        0 => f32::from_bits(u32::from_le_bytes(bytes.array())),
        1 => bytes.number_f32(),
        2 => {
            let texel = f32::from(i16::from_le_bytes(bytes.array()));
            near(bytes, texel / side)
        }
        3 => {
            let most = bytes.pick(&[4_194_304.0, 8_388_608.0, 2_147_483_648.0, -2_147_483_648.0]);
            near(bytes, most / side)
        }
        4 => before.last().copied().unwrap_or(0.5),
        5 => {
            let whole = bytes.small() as f32;
            near(bytes, whole)
        }
        _ => bytes.small() as f32 / 64.0,
    }
}

/// The definition, in whole numbers.
fn right(texels: &[[u8; 4]], sides: [u32; 2], at: [f32; 2]) -> [u8; 4] {
    let floors = [0, 1].map(|k| {
        let product = at[k] * sides[k] as f32;
        (product.abs() < 2_147_483_648.0).then(|| f64::from(product).floor() as i64)
    });
    let [column, row] = match floors {
        [Some(column), Some(row)] => [column, row],
        _ => [0, 0],
    };
    let [width, height] = sides.map(i64::from);
    let (column, row) = (column.rem_euclid(width), height - 1 - row.rem_euclid(height));
    texels[(row * width + column) as usize]
}
