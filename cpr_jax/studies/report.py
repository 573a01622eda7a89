"""The report of the case study, for people."""


def markdown_report(report: dict) -> str:
    """A Markdown page of what `cpr-jax paper` has found."""
    lines = [
        "# Sensitivity of a RFRFR continuum parallel robot: the paper's claims, computed",
        "",
        f"{report['samples']} samples a point, seed {report['seed']}; motors held, σ = δ/3. ",
        "Lost samples have no equilibrium left on the branch; they count as outside.",
        "",
        "![Figure 1](figure-1.png)",
        "",
        "![Figure 2](figure-2.png)",
        "",
        "![Figure 3](figure-3.png)",
        "",
        "| point | y, z (mm) | q₁, q₂ (rad) | semi-axes (mm) | inside | 95 % interval | lost |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, (y, z) in report["points"].items():
        q_1, q_2 = report["q_a"][name]
        major, minor = report["semi_axes"][name]
        low, high = report["coverage_interval"][name]
        lines.append(
            f"| {name} | {1e3 * y:g}, {1e3 * z:g} | {q_1:.6f}, {q_2:.6f} | "
            f"{1e3 * major:.3f}, {1e3 * minor:.3f} | {report['coverage'][name]:.2%} | "
            f"{low:.2%} to {high:.2%} | {report['lost'][name]} |"
        )
    lines += ["", "## Claims", "", "| the paper | computed | agrees |", "|---|---|---|"]
    for claim in report["claims"]:
        mark = "yes" if claim["agrees"] else "no"
        lines.append(f"| {claim['claim']} | {claim['computed']} | {mark} |")
    used = ", ".join(f"{name} {version}" for name, version in report["versions"].items())
    return "\n".join([*lines, "", f"Made with {used}.", ""])
