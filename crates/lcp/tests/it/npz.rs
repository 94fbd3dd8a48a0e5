//! A minimal reader of `.npz` files with stored (uncompressed) members.

use std::collections::HashMap;
use std::path::Path;

/// One array: its shape and its values as `f64`, row-major; strings are kept as bytes.
pub struct Array {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
    pub bytes: Vec<u8>,
}

impl Array {
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.bytes).trim_end_matches('\0').to_owned()
    }
}

pub fn read(path: &Path) -> HashMap<String, Array> {
    let file = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let u16_at = |p: usize| u16::from_le_bytes(file[p..p + 2].try_into().unwrap()) as usize;
    let u32_at = |p: usize| u32::from_le_bytes(file[p..p + 4].try_into().unwrap()) as usize;
    let end = (0..=file.len() - 22).rev().find(|&p| file[p..].starts_with(b"PK\x05\x06")).expect("zip end record");
    let mut arrays = HashMap::new();
    let mut entry = u32_at(end + 16);
    for _ in 0..u16_at(end + 10) {
        assert_eq!(u16_at(entry + 10), 0, "{}: a member is compressed", path.display());
        let (size, name_len) = (u32_at(entry + 20), u16_at(entry + 28));
        let name = String::from_utf8_lossy(&file[entry + 46..entry + 46 + name_len]).into_owned();
        let local = u32_at(entry + 42);
        let data = local + 30 + u16_at(local + 26) + u16_at(local + 28);
        arrays.insert(name.trim_end_matches(".npy").to_owned(), read_npy(&file[data..data + size]));
        entry += 46 + name_len + u16_at(entry + 30) + u16_at(entry + 32);
    }
    arrays
}

fn read_npy(npy: &[u8]) -> Array {
    assert!(npy.starts_with(b"\x93NUMPY"));
    let (header_len, start) = match npy[6] {
        1 => (u16::from_le_bytes([npy[8], npy[9]]) as usize, 10),
        _ => (u32::from_le_bytes(npy[8..12].try_into().unwrap()) as usize, 12),
    };
    let header = String::from_utf8_lossy(&npy[start..start + header_len]).into_owned();
    let field = |key: &str| header[header.find(key).expect("header key") + key.len() + 2..].trim_start();
    let kind = field("'descr'").trim_start_matches('\'').split('\'').next().unwrap().to_owned();
    let shape: Vec<usize> = field("'shape'")
        .trim_start_matches('(')
        .split(')')
        .next()
        .unwrap()
        .split(',')
        .filter_map(|s| s.trim().parse().ok())
        .collect();
    let bytes = npy[start + header_len..].to_vec();
    let mut values: Vec<f64> = match kind.trim_start_matches(['<', '|', '=']) {
        "f8" => bytes.chunks_exact(8).map(|c| f64::from_le_bytes(c.try_into().unwrap())).collect(),
        "i8" => bytes.chunks_exact(8).map(|c| i64::from_le_bytes(c.try_into().unwrap()) as f64).collect(),
        "i4" => bytes.chunks_exact(4).map(|c| f64::from(i32::from_le_bytes(c.try_into().unwrap()))).collect(),
        "u1" | "b1" => bytes.iter().map(|&b| f64::from(b)).collect(),
        _ => Vec::new(),
    };
    if field("'fortran_order'").starts_with("True") && shape.len() == 2 {
        let (rows, cols) = (shape[0], shape[1]);
        values = (0..rows * cols).map(|k| values[(k % cols) * rows + k / cols]).collect();
    }
    Array { shape, values, bytes }
}
