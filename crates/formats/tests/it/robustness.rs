//! Damaged documents: whatever is done to a model file, the answer is a model or a placed error, never a panic. The fuzz
//! targets look for more.

use signorini_formats::{FormatError, Imported, LoadOptions, load_mjcf_str, load_sdf_str, load_urdf_str};

use crate::support::Files;

type Read = fn(&str) -> Result<Imported, FormatError>;

fn mjcf(text: &str) -> Result<Imported, FormatError> {
    load_mjcf_str(text, "no such folder")
}

fn urdf(text: &str) -> Result<Imported, FormatError> {
    load_urdf_str(text, "no such folder", &LoadOptions::default())
}

fn sdf(text: &str) -> Result<Imported, FormatError> {
    load_sdf_str(text, "no such folder", &LoadOptions::default())
}

const DOCUMENTS: [(&str, Read); 11] = [
    (include_str!("../../testdata/mjcf/defaults.xml"), mjcf),
    (include_str!("../../testdata/mjcf/poses.xml"), mjcf),
    (include_str!("../../testdata/mjcf/fromto.xml"), mjcf),
    (include_str!("../../testdata/mjcf/inertia.xml"), mjcf),
    (include_str!("../../testdata/mjcf/joints.xml"), mjcf),
    (include_str!("../../testdata/mjcf/contacts.xml"), mjcf),
    (include_str!("../../testdata/mjcf/meshes.xml"), mjcf),
    (include_str!("../../testdata/urdf/arm.urdf"), urdf),
    (include_str!("../../testdata/urdf/floating.urdf"), urdf),
    (include_str!("../../testdata/mjcf/instruments.xml"), mjcf),
    (include_str!("../../testdata/sdf/arm.sdf"), sdf),
];

/// Values that parsers and formulas stumble over.
const HOSTILE: [&str; 14] = [
    "",
    " ",
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "9223372036854775808",
    "1 2 3 4 5 6 7 8",
    "world",
    "true",
    "\u{fffd}é",
];

/// A small generator (Marsaglia's xorshift), so that failures repeat.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n.max(1) as u64) as usize
    }
}

fn assert_survives(read: Read, text: &str) {
    if let Err(error) = read(text) {
        let message = error.to_string();
        assert!(message.contains(" text):"), "no place in '{message}' for {text}");
    }
}

#[test]
fn every_attribute_of_every_document_takes_every_hostile_value() {
    for (text, read) in DOCUMENTS {
        let marks: Vec<usize> = text.match_indices(['"', '\'']).map(|(i, _)| i).collect();
        for ends in marks.chunks_exact(2) {
            for value in HOSTILE {
                assert_survives(read, &format!("{}{value}{}", &text[..=ends[0]], &text[ends[1]..]));
            }
        }
    }
}

/// SDF's values are texts of elements.
#[test]
fn every_text_of_sdf_takes_every_hostile_value() {
    let (text, read) = DOCUMENTS[DOCUMENTS.len() - 1];
    let ends = text.match_indices("</").map(|(i, _)| i);
    for end in ends {
        let Some(start) = text[..end].rfind('>') else { continue };
        for value in HOSTILE {
            assert_survives(read, &format!("{}{value}{}", &text[..=start], &text[end..]));
        }
    }
}

#[test]
fn documents_survive_cuts_and_swaps() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for (text, read) in DOCUMENTS {
        let lines: Vec<&str> = text.lines().collect();
        for _ in 0..300 {
            let mut changed = lines.clone();
            for _ in 0..=random.below(3) {
                let (a, b) = (random.below(changed.len()), random.below(changed.len()));
                match random.below(3) {
                    0 => changed.swap(a, b),
                    1 => changed.insert(a, lines[random.below(lines.len())]),
                    _ => drop(changed.remove(a)),
                }
            }
            assert_survives(read, &changed.join("\n"));
        }
        for _ in 0..100 {
            let cut = random.below(text.len());
            assert_survives(read, &String::from_utf8_lossy(&text.as_bytes()[..cut]));
        }
    }
}

#[test]
fn deep_and_wide_documents_are_answered() {
    let chain = |n: usize| {
        let open = "<body><joint axis='0 1 0'/><geom size='.1'/>".repeat(n);
        format!("<mujoco><worldbody>{open}{}</worldbody></mujoco>", "</body>".repeat(n))
    };
    assert_eq!(mjcf(&chain(1000)).unwrap().model.nv, 1000);
    assert!(mjcf(&chain(5000)).unwrap_err().to_string().contains("nested more than"));
    let copies = "<replicate count='100000'>".repeat(3);
    let bomb = format!("<mujoco><worldbody>{copies}<geom size='1'/>{}</worldbody></mujoco>", "</replicate>".repeat(3));
    assert!(mjcf(&bomb).unwrap_err().to_string().contains("more than"));
    let models = |n: usize| {
        let open: String = (0..n).map(|k| format!("<model name='m{k}'>")).collect();
        format!("<sdf version='1.9'>{open}<link name='l'/>{}</sdf>", "</model>".repeat(n))
    };
    assert_eq!(sdf(&models(100)).unwrap().model.nv, 6);
    assert!(sdf(&models(1000)).unwrap_err().to_string().contains("nested more than"));
    let entities = "<!DOCTYPE m [<!ENTITY a 'aaaaaaaaaa'>]><mujoco model='&a;'/>";
    assert_eq!(mjcf(entities).unwrap().model.name, "&a;", "entities of a DTD are not expanded");
}

/// Files of editors that do not write UTF-8, and what they include: as the same files in UTF-8, with a warning at the line.
#[test]
fn files_in_other_ways_of_writing_are_read() {
    let robot = "<robot name=\"Füße\">\n<!-- 5 µm -->\n<link name=\"Fuß\"/>\n</robot>";
    let scene = "<mujoco>\n<worldbody>\n<include file=\"parts.xml\"/></worldbody></mujoco>";
    let parts = "<mujocoinclude>\n\n<body name=\"Fuß\"><freejoint/><geom size=\"1\"/></body></mujocoinclude>";
    let files = Files::new("latin", &[("scene.xml", scene), ("utf8.urdf", robot)]);
    let latin = |text: &str| -> Vec<u8> { text.chars().map(|c| u8::try_from(c).unwrap()).collect() };
    let utf16 = std::iter::once(0xfeff).chain(robot.encode_utf16()).flat_map(u16::to_le_bytes);
    std::fs::write(files.path("parts.xml"), latin(parts)).unwrap();
    std::fs::write(files.path("latin.urdf"), latin(robot)).unwrap();
    std::fs::write(files.path("utf16.urdf"), utf16.collect::<Vec<u8>>()).unwrap();
    std::fs::write(files.path("picture.urdf"), b"\x89PNG\0\0").unwrap();
    let read = |name: &str| signorini_formats::load(files.path(name), &LoadOptions::default());
    let written = |name: &str| -> Vec<(String, u32)> {
        let warnings = read(name).unwrap().report.warnings;
        let foreign = warnings.into_iter().filter(|warning| warning.to_string().contains("not UTF-8 text"));
        foreign.map(|warning| (warning.file.rsplit('/').next().unwrap().to_owned(), warning.line)).collect()
    };
    assert_eq!(written("scene.xml"), [("parts.xml".to_owned(), 3)]);
    assert_eq!(written("latin.urdf"), [("latin.urdf".to_owned(), 1)]);
    assert_eq!((written("utf8.urdf"), written("utf16.urdf")), (Vec::new(), Vec::new()));
    let hash = |name: &str| read(name).unwrap().model.content_hash();
    assert_eq!([hash("latin.urdf"), hash("utf16.urdf")], [hash("utf8.urdf"); 2]);
    assert!(read("scene.xml").unwrap().model.bodies.iter().any(|body| body.name == "Fuß"));
    let refused = read("picture.urdf").err().unwrap().to_string();
    assert!(refused.contains("picture.urdf") && refused.contains("not text"), "{refused}");
    assert_eq!(signorini_formats::read_text(files.path("latin.urdf")).unwrap(), robot);
}
