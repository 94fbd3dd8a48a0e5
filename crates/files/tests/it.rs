//! What is there after a file was written, and after it was not.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use signorini_files::{WholeFile, write};

/// A folder of a test's own, gone with it.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("signorini-files-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_file_that_is_not_finished_leaves_what_was_there() {
    let folder = Folder::new("unfinished");
    let path = folder.0.join("a.txt");
    write(&path, "old").unwrap();
    let mut file = WholeFile::create(&path).unwrap();
    file.write_all(&[b'x'; 100_000]).unwrap();
    assert_eq!(folder.names().len(), 2);
    drop(file);
    assert_eq!((fs::read_to_string(&path).unwrap(), folder.names()), ("old".into(), vec!["a.txt".to_owned()]));
}

#[test]
fn two_files_on_their_way_to_one_place_do_not_mix() {
    let folder = Folder::new("two");
    let path = folder.0.join("a.txt");
    let (mut first, mut second) = (WholeFile::create(&path).unwrap(), WholeFile::create(&path).unwrap());
    first.write_all(b"first").unwrap();
    second.write_all(b"second").unwrap();
    first.finish().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "first");
    second.finish().unwrap();
    assert_eq!((fs::read_to_string(&path).unwrap(), folder.names()), ("second".into(), vec!["a.txt".to_owned()]));
}

#[test]
fn errors_are_those_of_the_path() {
    let folder = Folder::new("errors");
    let missing = write(folder.0.join("no folder").join("a.txt"), "x").unwrap_err();
    assert_eq!(missing.kind(), std::io::ErrorKind::NotFound);
    assert!(write(&folder.0, "x").is_err());
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[cfg(unix)]
#[test]
fn links_permissions_and_devices_stay_what_they_are() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = Folder::new("links");
    let (path, link, dangling) = (folder.0.join("a.txt"), folder.0.join("link"), folder.0.join("dangling"));
    write(&path, "old").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    symlink(&path, &link).unwrap();
    write(&link, "new").unwrap();
    assert!(link.is_symlink());
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    symlink(folder.0.join("b.txt"), &dangling).unwrap();
    write(&dangling, "through").unwrap();
    assert_eq!(fs::read_to_string(folder.0.join("b.txt")).unwrap(), "through");
    write("/dev/null", "x").unwrap();
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let error = write("/dev/full", "x").unwrap_err();
    assert_eq!(error.kind(), std::io::ErrorKind::StorageFull);
}
