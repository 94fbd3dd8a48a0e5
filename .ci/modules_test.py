"""`modules.py` on made-up crates."""

import pathlib
import tempfile
import unittest

import modules


class Circles(unittest.TestCase):
    def circles(self, **files):
        """The circles of a crate with these files (`a__b` is `a/b.rs`), as sets of their names."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in files.items():
                path = root / (name.replace("__", "/") + ".rs")
                path.parent.mkdir(exist_ok=True)
                path.write_text(text)
            return [{str(file.relative_to(root))[:-3] for file in circle} for circle in modules.Crate(root).circles()]

    def test_two_files_that_use_each_other(self):
        lib = "mod a; mod b; mod c; pub use a::A;"
        a = "use crate::b::B; pub struct A(pub B);"
        b = "pub struct B; impl B { pub fn whole(&self) -> Option<crate::a::A> { None } }"
        c = "use crate::{a::A, b::{self, B}}; fn pair(a: A) -> B { b::B }"
        self.assertEqual(self.circles(lib=lib, a=a, b=b, c=c), [{"a", "b"}])
        self.assertEqual(self.circles(lib=lib, a=a, b="pub struct B;", c=c), [])

    def test_a_child_that_uses_its_parent(self):
        lib, child = "mod a;", "use super::Shared; pub fn read(shared: &Shared) {}"
        self.assertEqual(
            self.circles(lib=lib, a__mod="mod child; pub struct Shared; fn all(s: &Shared) { child::read(s) }", a__child=child),
            [{"a/mod", "a/child"}],
        )
        # Without a use of the child, its parent only declares it.
        self.assertEqual(self.circles(lib=lib, a__mod="mod child; pub struct Shared; pub use child::read;", a__child=child), [])

    def test_methods_that_another_file_adds(self):
        lib = "mod a; mod b;"
        a = "pub struct A; pub fn go(a: &A) { a.extra() }"
        self.assertEqual(self.circles(lib=lib, a=a, b="use crate::a::A; impl A { pub fn extra(&self) {} }"), [{"a", "b"}])
        # A call without arguments is not one of a method that takes some.
        self.assertEqual(self.circles(lib=lib, a=a, b="use crate::a::A; impl A { pub fn extra(&self, x: u8) {} }"), [])

    def test_tests_texts_and_other_crates_do_not_count(self):
        lib = "mod a; mod b; pub use other::Noun;"
        a = "pub struct A; #[cfg(test)] mod tests { use crate::b::B; }"
        b = 'use crate::{Noun, a::A}; pub struct B(A, Noun); // a::A knows b::B\nconst TEXT: &str = "crate::a::A";'
        self.assertEqual(self.circles(lib=lib, a=a, b=b), [])
        self.assertEqual(self.circles(lib=lib, a="use crate::b::B; pub struct A;", b=b), [{"a", "b"}])
