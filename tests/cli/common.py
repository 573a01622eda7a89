"""Commands as users call them, in this process."""

from cpr_jax.cli import main


def run(capsys, *argv):
    """Exit code, standard output and standard error of a command."""
    code = main(list(argv))
    out, err = capsys.readouterr()
    return code, out, err
