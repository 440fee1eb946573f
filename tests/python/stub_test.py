import ast
import inspect
import os
import pathlib
import subprocess
import sys

import saccade

STUB = ast.parse((pathlib.Path(saccade.__file__).parent / "__init__.pyi").read_text())


def definitions(body):
    return {node.name: node for node in body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}


def test_the_stub_names_what_the_module_offers():
    names = set(definitions(STUB.body)) | {n.target.id for n in STUB.body if isinstance(n, ast.AnnAssign)}
    assert names == set(saccade.__all__) | {"__version__"}


def test_functions_of_the_stub_have_the_arguments_of_the_module():
    checked = 0
    for name, node in definitions(STUB.body).items():
        if isinstance(node, ast.FunctionDef):
            arguments = [a.arg for a in node.args.args + node.args.kwonlyargs]
            arguments += [node.args.kwarg.arg] if node.args.kwarg else []
            assert arguments == list(inspect.signature(getattr(saccade, name)).parameters), name
            checked += 1
    assert checked > 10


def test_classes_of_the_stub_have_the_members_of_the_module():
    for name, node in definitions(STUB.body).items():
        if not isinstance(node, ast.ClassDef):
            continue
        ours = {m for m in definitions(node.body)} - {"__init__"}
        theirs = {m for m in dir(getattr(saccade, name)) if not m.startswith("_")}
        assert {m for m in ours if not m.startswith("_")} <= theirs, name
        of_gymnasium = {"metadata", "render_mode", "spec", "np_random_seed", "get_wrapper_attr", "has_wrapper_attr",
                        "set_wrapper_attr"}
        assert theirs - of_gymnasium <= ours, name


def test_everything_offered_has_a_docstring():
    for name in saccade.__all__:
        thing = getattr(saccade, name)
        if callable(thing):
            assert thing.__doc__, name


def test_an_interpreter_of_another_version_is_told_the_versions_there_are(tmp_path):
    package = tmp_path / "saccade"
    package.mkdir()
    for file in pathlib.Path(saccade.__file__).parent.glob("*.py"):
        (package / file.name).write_text(file.read_text())
    (package / "_saccade.cpython-31-x86_64-linux-gnu.so").write_bytes(b"")
    (package / "_saccade.cpython-399-x86_64-linux-gnu.so").write_bytes(b"")
    done = subprocess.run([sys.executable, "-c", "import saccade"], env={**os.environ, "PYTHONPATH": str(tmp_path)},
                          capture_output=True, text=True)
    assert done.returncode == 1
    assert f"ImportError: saccade is built for Python 3.1, 3.99: found Python {sys.version.split()[0]}" in done.stderr
