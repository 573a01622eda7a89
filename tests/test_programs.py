"""Programs that are kept, on disk or not: the same answers, and nothing traced twice."""

import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from cpr_jax import program_name, programs
from cpr_jax.programs import brief_program, hot_program, program


class Answer(NamedTuple):
    doubled: jax.Array
    note: str
    nothing: None


def counted(traces: list):
    """A program that notes each of its traces."""

    @program
    def double(tree, factor=2):
        traces.append(factor)
        return Answer(factor * tree["x"] + tree["y"], f"by {factor}", None)

    return double


TREE = {"x": jnp.arange(3.0), "y": jnp.ones(())}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    # Not `use_cache`: the folder of JAX's own cache is that of the whole process.
    monkeypatch.setattr(programs, "_folder", tmp_path)
    return tmp_path


def files(folder):
    return sorted((folder / "programs").iterdir())


def test_a_kept_program_is_not_traced_again(folder):
    traces: list = []
    first = counted(traces)(TREE)
    again = counted(traces)(TREE)
    assert traces == [2]
    assert len(files(folder)) == 1
    assert again.note == "by 2" and again.nothing is None
    np.testing.assert_array_equal(again.doubled, first.doubled)
    np.testing.assert_array_equal(again.doubled, [1.0, 3.0, 5.0])


def test_one_process_makes_a_program_once():
    traces: list = []
    double = counted(traces)
    for _ in range(3):
        double(TREE)
    double({"x": np.arange(3.0), "y": np.ones(())})
    assert traces == [2]


def test_without_a_folder_a_process_makes_a_program_once(monkeypatch):
    monkeypatch.setattr(programs, "_folder", None)
    traces: list = []
    double = counted(traces)
    for tree in (TREE, TREE, {"x": np.arange(3.0), "y": np.ones(())}):
        answer = double(tree)
        np.testing.assert_array_equal(answer.doubled, [1.0, 3.0, 5.0])
        assert answer.note == "by 2" and answer.nothing is None
    assert traces == [2]
    double(TREE, 3)
    programs.forget_all()
    double(TREE, 3)
    assert traces == [2, 3, 3]


def test_the_switches_that_look_for_mistakes_work():
    """What is compiled ahead of its calls knows none of them."""

    @program
    def divide(a, b):
        known.append(not isinstance(a, jax.core.Tracer))
        return a / b

    known: list = []
    zero = jnp.zeros(())
    assert np.isnan(divide(zero, zero))
    assert not any(known)
    with jax.debug_nans(True), pytest.raises(FloatingPointError):
        divide(zero, zero)
    known.clear()
    with jax.disable_jit():
        divide(zero, zero)
    assert known == [True]


def test_every_difference_that_matters_makes_another_program(folder):
    traces: list = []
    double = counted(traces)
    for factor in (1, 1.0, True, 3):
        answer = double(TREE, factor)
        assert answer.note == f"by {factor}"
    double({"x": jnp.arange(4.0), "y": jnp.ones(())})
    double({"x": jnp.arange(3), "y": jnp.ones(())})
    double({"x": 5.0, "y": jnp.ones(())})
    assert len(traces) == 7
    assert len(files(folder)) == 7


def test_other_source_makes_another_program(monkeypatch, folder):
    traces: list = []
    counted(traces)(TREE)
    monkeypatch.setattr(program_name, "_foundation", lambda: "another version")
    counted(traces)(TREE)
    assert len(traces) == 2


@pytest.mark.parametrize("content", [b"", b"garbage", None])
def test_a_damaged_file_is_made_anew(folder, content):
    traces: list = []
    counted(traces)(TREE)
    (file,) = files(folder)
    file.write_bytes(file.read_bytes()[:-20] if content is None else content)
    np.testing.assert_array_equal(counted(traces)(TREE).doubled, [1.0, 3.0, 5.0])
    counted(traces)(TREE)
    assert len(traces) == 2


def test_a_folder_that_cannot_be_written_costs_nothing_else(monkeypatch, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setattr(programs, "_folder", blocked)
    np.testing.assert_array_equal(counted([])(TREE).doubled, [1.0, 3.0, 5.0])


def test_a_static_without_a_name_is_not_kept(folder):
    @program
    def apply(function, x):
        return function(x)

    assert float(apply(lambda x: x + 1.0, jnp.ones(()))) == 2.0
    assert not (folder / "programs").exists()


def test_transformations_see_the_function_itself(folder):
    double = counted([])

    def doubled(x):
        return double({"x": x, "y": jnp.ones(())}).doubled

    x = jnp.arange(3.0)
    np.testing.assert_array_equal(jax.jit(doubled)(x), [1.0, 3.0, 5.0])
    np.testing.assert_array_equal(jax.vmap(doubled)(x), [1.0, 3.0, 5.0])
    np.testing.assert_array_equal(jax.jacfwd(doubled)(x), 2.0 * np.eye(3))
    assert not (folder / "programs").exists()


def test_a_program_without_traced_arguments_can_be_part_of_another():
    double = counted([])

    def shifted(x):
        return x + double({"x": jnp.ones(3), "y": jnp.ones(())}).doubled

    expected = [3.0, 4.0, 5.0]  # 2 · 1 + 1 = 3 more
    np.testing.assert_array_equal(shifted(jnp.arange(3.0)), expected)
    np.testing.assert_array_equal(jax.jit(shifted)(jnp.arange(3.0)), expected)


def test_sums_of_products_are_right():
    # jaxlib 0.10.2 gets the last of them wrong (jax-ml/jax#39103) unless it is told how to sum.
    @programs.program
    def lengths(rows):
        return jax.vmap(lambda row: jnp.sum((jnp.eye(3) @ row) ** 2))(rows)

    first = jnp.arange(16_385.0)
    rows = jnp.stack((first, 0.0 * first, 0.0 * first), axis=1)
    np.testing.assert_array_equal(lengths(rows), first**2)


@pytest.fixture
def hardly_optimised():
    """Sets whether JAX is to leave most optimisations out."""
    before = jax.config.read("jax_disable_most_optimizations")
    yield lambda value: jax.config.update("jax_disable_most_optimizations", value)
    jax.config.update("jax_disable_most_optimizations", before)


def test_programs_heed_what_jax_is_told_of_optimisations(hardly_optimised):
    traces: list = []
    double = counted(traces)
    for value, level in ((True, 0), (False, 1), (True, 0)):
        hardly_optimised(value)
        if jax.default_backend() == "cpu":
            assert double._options["xla_backend_optimization_level"] == level
        np.testing.assert_array_equal(double(TREE).doubled, [1.0, 3.0, 5.0])
    # Compiled for either, traced for both.
    assert len(double._known) == 2 and traces == [2]


def test_what_runs_longer_is_compiled_for_longer(hardly_optimised):
    if jax.default_backend() != "cpu":
        pytest.skip("these are options of the CPU")
    hardly_optimised(False)
    kinds = (brief_program, program, hot_program)
    levels = [kind(len)._options["xla_backend_optimization_level"] for kind in kinds]
    assert levels == [0, 1, 3]


def test_options_that_this_release_does_not_know_are_left_out(hardly_optimised):
    hardly_optimised(False)

    def double(x):
        return 2.0 * x

    apart = programs._Program(double, {"xla_no_such_option": 1, "xla_cpu_prefer_vector_width": 256})
    np.testing.assert_array_equal(apart(jnp.arange(3.0)), [0.0, 2.0, 4.0])
    known = {"xla_cpu_prefer_vector_width": 256} if jax.default_backend() == "cpu" else {}
    assert apart._options == known


SOLVE = """
import sys
import jax
import cpr_jax as cpr
from cpr_jax import program_name, programs

jax.config.update("jax_enable_x64", True)
cpr.use_cache(sys.argv[1])
made = []
make = programs._Program._make
programs._Program._make = lambda self, *rest: made.append(self.__name__) or make(self, *rest)
robot = cpr.rfrfr()
equilibrium = cpr.solve_inverse(robot, (0.05, 0.15))
result = cpr.sensitivity(robot, equilibrium)
print(len(made), equilibrium.y.tolist(), result.Pi_p.tolist(), sep="|")
"""


def test_a_second_process_starts_from_the_first(tmp_path):
    runs = [
        subprocess.run(
            [sys.executable, "-c", SOLVE, str(tmp_path)], capture_output=True, text=True, check=True
        ).stdout.split("|")
        for _ in range(2)
    ]
    assert int(runs[0][0]) > 0
    assert int(runs[1][0]) == 0
    assert runs[0][1:] == runs[1][1:]


def test_programs_are_traced_in_turn():
    """One is there to be compiled while the next is traced, rather than all at the end."""
    now, most = [0], [0]

    @program
    def traced(x, added):
        now[0] += 1
        most[0] = max(most[0], now[0])
        # Others would be let in here.
        time.sleep(0.05)
        now[0] -= 1
        return x + added

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda added: float(traced(jnp.ones(()), added)), range(4)))
    assert found == [1.0, 2.0, 3.0, 4.0]
    assert most == [1]


DEVICES = """
import jax
jax.config.update("jax_num_cpu_devices", 2)
import numpy as np
from cpr_jax.programs import brief_program, hot_program, program
first, second = jax.devices()

@program
def double(x):
    return 2.0 * x

three = np.arange(3.0)
places = [double(three).devices()]
with jax.default_device(second):
    places.append(double(three).devices())
    free = jax.numpy.asarray(three)
places.append(double(free).devices())
places.append(double(jax.device_put(three, second)).devices())
print(places == [{first}, {second}, double.__wrapped__(free).devices(), {second}])
"""


def test_programs_run_where_their_arrays_and_jax_say():
    run = [sys.executable, "-c", DEVICES]
    found = subprocess.run(run, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "True"
