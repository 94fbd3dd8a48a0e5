"""What the package promises as a whole."""

import doctest
import inspect
import pathlib
import re

import signorini
import typed_program


def test_a_program_that_uses_every_public_name():
    text = pathlib.Path(typed_program.__file__).read_text()
    unused = [name for name in signorini.__all__ if not re.search(rf"\b{name}\b", text)]
    assert not unused
    typed_program.main()


def test_everything_public_is_documented():
    bare = []
    for name in signorini.__all__:
        thing = getattr(signorini, name)
        if name != "__version__" and not inspect.getdoc(thing):
            bare.append(name)
        if inspect.isclass(thing) and not issubclass(thing, (BaseException, int)):
            members = [m for m in vars(thing) if not m.startswith("_")]
            fields = getattr(thing, "__dataclass_fields__", {})
            bare += [f"{name}.{m}" for m in members if m not in fields and not inspect.getdoc(getattr(thing, m))]
    assert not bare


def test_the_example_of_the_packages_docstring():
    assert doctest.testmod(signorini).attempted == 5 and not doctest.testmod(signorini).failed
