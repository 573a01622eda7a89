"""Sections, materials and the rods made from them."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate

from cpr_jax.errors import InputError
from cpr_jax.geometry import PLANE, SPACE
from cpr_jax.rods.rod import kirchhoff_rod, section_rod
from cpr_jax.rods.section import Material, circle, rectangle


def test_the_section_of_table_1_and_its_stiffness_belong_to_a_polymer():
    """`k_b = E w³ h / 12` with w = 2 mm in the plane, h = 10 mm: E = 2.745 GPa."""
    section = rectangle(2e-3, 10e-3)
    assert pytest.approx(2.745e9, rel=1e-12) == 1.83e-2 / section.I_3
    rod = section_rod(PLANE, 0.25, section, Material(E=2.745e9))
    np.testing.assert_allclose(1.0 / rod.curvature_compliance, [1.83e-2], rtol=1e-12)


def test_second_moments_of_a_rectangle_by_quadrature():
    width, height = 0.3, 0.2

    def second(power_2, power_3):
        return scipy.integrate.dblquad(
            lambda y, z: y**power_2 * z**power_3,
            -height / 2.0,
            height / 2.0,
            -width / 2.0,
            width / 2.0,
        )[0]

    section = rectangle(width, height)
    assert section.area == pytest.approx(second(0, 0))
    # Bending about axis 3 stretches along axis 2, of extent `width`.
    assert pytest.approx(second(2, 0)) == section.I_3
    assert pytest.approx(second(0, 2)) == section.I_2


def test_a_width_may_be_designed():
    """`I_3 = h w³ / 12`, so that its slope is `h w² / 4`, inside of a program too."""
    slope = jax.jit(jax.grad(lambda width: rectangle(width, 0.2).I_3))(0.3)
    assert slope == pytest.approx(0.2 * 0.3**2 / 4.0)
    slopes = jax.grad(lambda width: rectangle(width, 0.2).J)
    step = 1e-6
    by_hand = (rectangle(0.3 + step, 0.2).J - rectangle(0.3 - step, 0.2).J) / (2.0 * step)
    assert slopes(0.3) == pytest.approx(by_hand, rel=1e-7)


@pytest.mark.parametrize("ratio", [1.0, 0.7, 0.3, 0.05])
def test_torsion_of_a_rectangle_against_the_full_series(ratio):
    """Saint-Venant: `J = b a³ (1/3 - 64/π⁵ (a/b) Σ tanh(k π b / 2a) / k⁵)` over odd k."""
    long, short = 0.2, 0.2 * ratio
    k = np.arange(1, 200, 2)
    series = np.sum(np.tanh(k * np.pi * long / (2.0 * short)) / k**5)
    exact = long * short**3 * (1.0 / 3.0 - 64.0 / np.pi**5 * ratio * series)
    assert pytest.approx(exact, rel=5e-3) == rectangle(long, short).J
    assert rectangle(short, long).J == rectangle(long, short).J


def test_second_moments_of_a_circle():
    section = circle(0.01)
    polar = scipy.integrate.quad(lambda r: 2.0 * np.pi * r**3, 0.0, 0.01)[0]
    assert pytest.approx(polar) == section.J
    assert section.I_2 == section.I_3 == pytest.approx(polar / 2.0)
    assert section.area == pytest.approx(np.pi * 1e-4)


def test_compliances_are_in_the_order_of_the_local_axes():
    section, material = rectangle(2e-3, 10e-3), Material(E=2e9, nu=0.25)
    assert pytest.approx(0.8e9) == material.G
    curvature, strain = section.compliances(SPACE, material)
    E, G = 2e9, 0.8e9
    np.testing.assert_allclose(1.0 / curvature, [G * section.J, E * section.I_2, E * section.I_3])
    shear = G * section.area * 5.0 / 6.0
    np.testing.assert_allclose(1.0 / strain, [E * section.area, shear, shear])
    planar_curvature, planar_strain = section.compliances(PLANE, material)
    np.testing.assert_allclose(planar_curvature, curvature[2:])
    np.testing.assert_allclose(planar_strain, strain[:2])


def test_a_rod_from_a_section_carries_its_weight():
    section, material = circle(1e-3), Material(E=200e9, density=8000.0)
    rod = section_rod(SPACE, 0.5, section, material, gravity=(0.0, 0.0, -9.81))
    np.testing.assert_allclose(rod.force, [0.0, 0.0, -9.81 * 8000.0 * np.pi * 1e-6])
    assert rod.strain_compliance is None and rod.moment is None


def test_arguments_in_the_wrong_order_are_named():
    section, material = circle(1e-3), Material(E=2e9, nu=0.3)
    with pytest.raises(InputError, match="`section` must be a Section, such as"):
        section_rod(SPACE, 0.25, material, section)
    with pytest.raises(InputError, match="`material` must be a Material"):
        section_rod(SPACE, 0.25, section, 2e9)


def test_only_an_extensible_rod_has_a_strain_compliance():
    section, material = circle(1e-3), Material(E=200e9)
    rod = section_rod(PLANE, 0.5, section, material, precurvature=2.0, extensible=True)
    np.testing.assert_allclose(rod.strain_compliance, section.compliances(PLANE, material)[1])
    np.testing.assert_allclose(rod.precurvature, [2.0])
    assert rod.force is None


def test_stiffness_and_precurvature_of_a_kirchhoff_rod():
    rod = kirchhoff_rod(SPACE, 1, 4.0, 0.5, force=(0, 0, -1))
    np.testing.assert_allclose(rod.curvature_compliance, [0.25, 0.25, 0.25])
    np.testing.assert_allclose(rod.precurvature, [0.0, 0.0, 0.5])
    vector = kirchhoff_rod(SPACE, 1.0, (1.0, 2.0, 4.0), (0.1, 0.2, 0.3))
    np.testing.assert_allclose(vector.curvature_compliance, [1.0, 0.5, 0.25])
    np.testing.assert_allclose(vector.precurvature, [0.1, 0.2, 0.3])
    # Integers must not make integer leaves.
    assert all(jnp.issubdtype(leaf.dtype, jnp.floating) for leaf in (rod.length, rod.force))
