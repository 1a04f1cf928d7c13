//! The OBJ reader on any bytes: a model whose indices all name something, or an error that names
//! the file. No panic, no hang; and
//!
//! - it is the same in pieces and with other line ends;
//! - every face has three corners or more, uses of materials come in order and name one;
//! - no list takes more memory than the bytes are worth.

use std::path::Path;

use super::readers::{NAME, check_size, read};
use crate::obj::{self, ABSENT, Obj};

pub(crate) fn obj(data: &[u8]) {
    let path = Path::new(NAME);
    let parse = |lines| obj::parse(lines, path, |_| {});
    let Some(obj) = read(data, parse) else { return };
    let Obj { positions, colors, uvs, normals, corners, face_ends, .. } = &obj;
    assert!(corners.position.iter().all(|i| (*i as usize) < positions.len()));
    let known = |i: &u32, n: usize| *i == ABSENT || (*i as usize) < n;
    assert!(corners.uv.iter().all(|i| known(i, uvs.len())));
    assert!(corners.normal.iter().all(|i| known(i, normals.len())));
    assert_eq!([corners.uv.len(), corners.normal.len()], [corners.len(); 2]);
    assert!(colors.is_empty() || colors.len() == positions.len());

    let starts = [0].iter().chain(face_ends);
    assert!(starts.zip(face_ends).all(|(start, end)| *end >= *start + 3));
    assert_eq!(face_ends.last().map(|end| *end as usize), Some(corners.len()));
    assert!(obj.material_uses.is_sorted_by_key(|(face, _)| *face));
    let last = obj.material_uses.last();
    assert!(last.is_none_or(|(face, _)| *face <= face_ends.len()));
    assert!(obj.material_uses.iter().all(|(_, name)| *name < obj.material_names.len()));
    for named in [&obj.material_names, &obj.libraries] {
        assert!(
            named.iter().all(|(_, line)| *line > 0) && named.is_sorted_by_key(|(_, line)| *line)
        );
    }

    let n = data.len();
    check_size(positions, n);
    check_size(colors, n);
    check_size(uvs, n);
    check_size(normals, n);
    check_size(&corners.position, n);
    check_size(face_ends, n);
    check_size(&obj.material_uses, n);
    check_size(&obj.material_names, n);
    check_size(&obj.libraries, n);
}
