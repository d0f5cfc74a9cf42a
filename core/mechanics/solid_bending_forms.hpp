#pragma once

#include "core/mechanics/element_forms.hpp"

namespace dccast::mechanics {

/// The forms of the hexahedron whose strain is its mean and bending modes (fem::SolidBending). The
/// modes preserve the volume, so that the mean dilatation holds at every point.
///
/// Strain and stiffness are expressed by 18 generalised strains: the six components of the mean,
/// and either the amplitudes of the twelve modes or the components of the four warps from which the
/// modes follow.
template <class Number>
struct ElementForms<fem::BendingHexahedron, Number, true>
    : ElementFormsBase<fem::BendingHexahedron, Number> {
  using Base = ElementFormsBase<fem::BendingHexahedron, Number>;
  using Base::dim, Base::nodes, Base::points, Base::unknowns;
  using typename Base::Cell, typename Base::Matrix, typename Base::Pressures,
      typename Base::Responses, typename Base::Tensor, typename Base::Tensors,
      typename Base::Vectors;
  using Bending = fem::SolidBending;
  /// Warps have three components each; the mean has the six of a symmetric tensor.
  static constexpr std::size_t warps = Bending::warps, modes = Bending::modes,
                               levers = Bending::levers, means = 6, generalised = means + modes;

  /// Strain at every point [1].
  static Tensors strains(const Cell& c, const Vectors& v) {
    Tensors strains = strain_deviators(c, v);
    const Number dilatation = Base::mean_dilatation(c, v);
    for (Tensor& strain : strains) strain.add_identity(dilatation / 3.0);
    return strains;
  }

  /// Strain deviators [1] at every point: that of the mean, and each lever with its linear strain.
  static Tensors strain_deviators(const Cell& c, const Vectors& v) {
    const Tensor mean = mean_strain(c, v).deviator();
    const auto linear = strains_of_levers(c, v);
    Tensors deviators;
    deviators.fill(mean);
    for (std::size_t q = 0; q < points; ++q) {
      for (std::size_t l = 0; l < levers; ++l) deviators[q].add(c.point[q].lever[l], linear[l]);
    }
    return deviators;
  }

  /// Nodal forces [N] of stress deviators and mean normal stresses [Pa].
  static Vectors forces(const Cell& c, const Tensors& deviator, const Pressures& pressure) {
    Tensor sum;  // of the stress over the volume [N m], its deviator
    std::array<Tensor, levers> moment{};
    Number pressures{};
    for (std::size_t q = 0; q < points; ++q) {
      const Number weight = c.point[q].weight;
      sum.add(weight, deviator[q]);
      pressures += weight * pressure[q];
      for (std::size_t l = 0; l < levers; ++l) {
        moment[l].add(weight * c.point[q].lever[l], deviator[q]);
      }
    }
    sum.add_identity(pressures);
    const auto of_warp = forces_of_warps(c, moment);
    Vectors force;
    for (std::size_t i = 0; i < nodes; ++i) {
      const auto& g = c.mean_gradient[i];
      for (std::size_t a = 0; a < dim; ++a) {
        Number f = sum.at(a, 0) * g[0] + sum.at(a, 1) * g[1] + sum.at(a, 2) * g[2];
        for (std::size_t w = 0; w < warps; ++w) f += c.bending.warp[w][i] * of_warp[w][a];
        force[i][a] = f;
      }
    }
    return force;
  }

  /// Stiffness [N/m] from the responses at the points and the bulk modulus [Pa], lower triangle. It
  /// is B^T D B with D by generalised strain and B the strains of unit displacements.
  static Matrix stiffness(const Cell& c, const Responses& response, const Number& bulk_modulus) {
    Moduli d = moduli(c, response, bulk_modulus);
    modes_to_warps(c, d);
    Matrix k{};
    for (std::size_t j = 0; j < nodes; ++j) {
      const auto stress = stresses_of_unit_displacements(c, d, j);
      for (std::size_t i = j; i < nodes; ++i) {
        for (std::size_t b = 0; b < dim; ++b) {
          const auto force = force_at(c, i, stress[b]);
          for (std::size_t a = 0; a < dim; ++a) {
            k[(dim * i + a) * unknowns + dim * j + b] = force[a];
          }
        }
      }
    }
    return k;
  }

private:
  /// By generalised strain.
  using Generalised = std::array<Number, generalised>;
  /// D by generalised strain, symmetric [N m].
  using Moduli = std::array<Generalised, generalised>;
  /// A tensor whose shear is scaled so that products of tensors are products of vectors.
  using Scaled = std::array<Number, 6>;
  /// (warp, direction) of a displacement [m] or a force [N].
  using OfWarps = std::array<std::array<Number, 3>, warps>;
  /// The two directions of the shears xy, yz, xz.
  static constexpr std::size_t pair[3][2] = {{0, 1}, {1, 2}, {0, 2}};

  /// Components of a tensor with shear times sqrt(2), so that dot() gives the double contraction.
  static Scaled scaled(const Tensor& t) {
    constexpr double root = 1.41421356237309504880;  // two shear components in a product
    return {t[0], t[1], t[2], root * t[3], root * t[4], root * t[5]};
  }
  static Number dot(const Scaled& a, const Scaled& b) {
    Number sum = a[0] * b[0];
    for (std::size_t i = 1; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }

  /// Mean of the strain over the element [1]. @param v  displacements [m]
  static Tensor mean_strain(const Cell& c, const Vectors& v) {
    Tensor mean;
    for (std::size_t i = 0; i < nodes; ++i) {
      const auto& g = c.mean_gradient[i];
      for (std::size_t a = 0; a < dim; ++a) mean[a] += g[a] * v[i][a];
      for (std::size_t s = 0; s < 3; ++s) {
        const auto [a, b] = pair[s];
        mean[3 + s] += 0.5 * (g[a] * v[i][b] + g[b] * v[i][a]);
      }
    }
    return mean;
  }

  /// Strain contributed by each lever per unit of the lever.
  static std::array<Tensor, levers> strains_of_levers(const Cell& c, const Vectors& v) {
    OfWarps q{};
    for (std::size_t w = 0; w < warps; ++w) {
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) q[w][a] += c.bending.warp[w][i] * v[i][a];
      }
    }
    std::array<Tensor, levers> linear{};
    for (std::size_t m = 0; m < modes; ++m) {
      const auto& mode = c.bending.mode[m];
      Number amplitude{};
      for (std::size_t j = 0; j < 2; ++j) {
        const auto& of_warp = q[Bending::warps_of(m)[j]];
        for (std::size_t a = 0; a < dim; ++a) amplitude += mode.share[j][a] * of_warp[a];
      }
      linear[Bending::lever_of(m)].add(amplitude, mode.strain);
    }
    return linear;
  }

  /// Forces that work on the warps [N], from the moments of the stress.
  /// @param moment  (lever) stress deviator times lever, integrated over the element
  static OfWarps forces_of_warps(const Cell& c, const std::array<Tensor, levers>& moment) {
    OfWarps force{};
    for (std::size_t m = 0; m < modes; ++m) {
      const auto& mode = c.bending.mode[m];
      const Number of_mode = dot(scaled(moment[Bending::lever_of(m)]), scaled(mode.strain));
      for (std::size_t j = 0; j < 2; ++j) {
        auto& of_warp = force[Bending::warps_of(m)[j]];
        for (std::size_t a = 0; a < dim; ++a) of_warp[a] += of_mode * mode.share[j][a];
      }
    }
    return force;
  }

  /// Deviators of unit generalised strains.
  static std::array<Scaled, generalised> unit_strains(const Cell& c) {
    std::array<Scaled, generalised> strain;
    for (std::size_t n = 0; n < means; ++n) {
      Tensor t;
      t[n] += 1.0;
      strain[n] = scaled(t.deviator());
    }
    for (std::size_t m = 0; m < modes; ++m) strain[means + m] = scaled(c.bending.mode[m].strain);
    return strain;
  }
  /// Index of the lever of a generalised strain; zero for the mean.
  static constexpr std::size_t lever_of(std::size_t n) {
    return n < means ? 0 : 1 + Bending::lever_of(n - means);
  }

  /// Moduli that relate mean strain and mode amplitudes.
  static Moduli moduli(const Cell& c, const Responses& response, const Number& bulk_modulus) {
    const auto strain = unit_strains(c);
    Moduli d{};
    Number shear[1 + levers][1 + levers] = {};  // moments of twice the shear modulus
    for (std::size_t q = 0; q < points; ++q) {
      Number lever[1 + levers] = {Number{} + 1.0};
      for (std::size_t l = 0; l < levers; ++l) lever[1 + l] = c.point[q].lever[l];
      const Number stiff = 2.0 * c.point[q].weight * response[q].shear;
      for (std::size_t l = 0; l <= levers; ++l) {
        for (std::size_t m = 0; m <= levers; ++m) shear[l][m] += stiff * lever[l] * lever[m];
      }
      add_softening(d, c.point[q].weight * response[q].softening, scaled(response[q].deviator),
                    strain, lever);
    }
    for (std::size_t n = 0; n < generalised; ++n) {
      for (std::size_t m = 0; m <= n; ++m) {
        d[n][m] += shear[lever_of(n)][lever_of(m)] * dot(strain[n], strain[m]);
        if (n < 3) d[n][m] += bulk_modulus * c.volume;
        d[m][n] = d[n][m];
      }
    }
    return d;
  }

  /// Adds the softening by creep in the direction of the stress at a point, to the lower triangle.
  static void add_softening(Moduli& d, const Number& softening, const Scaled& stress,
                            const std::array<Scaled, generalised>& strain,
                            const Number (&lever)[1 + levers]) {
    Generalised along;
    for (std::size_t n = 0; n < generalised; ++n) {
      along[n] = lever[lever_of(n)] * dot(stress, strain[n]);
    }
    for (std::size_t n = 0; n < generalised; ++n) {
      const Number factor = softening * along[n];
      for (std::size_t m = 0; m <= n; ++m) d[n][m] += factor * along[m];
    }
  }

  /// Transforms both sides from mode amplitudes to warp components.
  static void modes_to_warps(const Cell& c, Moduli& d) {
    for (Generalised& row : d) row = to_warps(c, row);
    for (std::size_t n = 0; n < generalised; ++n) {
      Generalised column;
      for (std::size_t m = 0; m < generalised; ++m) column[m] = d[m][n];
      column = to_warps(c, column);
      for (std::size_t m = 0; m < generalised; ++m) d[m][n] = column[m];
    }
  }
  /// Transforms one side, from amplitudes of modes to components of warps.
  static Generalised to_warps(const Cell& c, const Generalised& of_modes) {
    Generalised of_warps{};
    for (std::size_t n = 0; n < means; ++n) of_warps[n] = of_modes[n];
    for (std::size_t m = 0; m < modes; ++m) {
      for (std::size_t j = 0; j < 2; ++j) {
        Number* of_warp = &of_warps[means + dim * Bending::warps_of(m)[j]];
        for (std::size_t a = 0; a < dim; ++a) {
          of_warp[a] += of_modes[means + m] * c.bending.mode[m].share[j][a];
        }
      }
    }
    return of_warps;
  }

  /// Generalised stresses (mean and warps) caused by unit displacements of a node, by direction.
  static std::array<Generalised, dim> stresses_of_unit_displacements(const Cell& c, const Moduli& d,
                                                                     std::size_t node) {
    std::array<Generalised, dim> stress;
    for (std::size_t n = 0; n < generalised; ++n) {
      const auto force = force_at(c, node, d[n]);  // the moduli are symmetric
      for (std::size_t a = 0; a < dim; ++a) stress[a][n] = force[a];
    }
    return stress;
  }
  /// Force at a node caused by generalised stresses (mean and warps).
  static std::array<Number, dim> force_at(const Cell& c, std::size_t node,
                                          const Generalised& stress) {
    const auto& g = c.mean_gradient[node];
    std::array<Number, dim> force;
    for (std::size_t a = 0; a < dim; ++a) {
      force[a] = g[a] * stress[a];
      for (std::size_t w = 0; w < warps; ++w) {
        force[a] += c.bending.warp[w][node] * stress[means + dim * w + a];
      }
    }
    for (std::size_t s = 0; s < 3; ++s) {
      const auto [a, b] = pair[s];
      force[a] += 0.5 * g[b] * stress[means - 3 + s];
      force[b] += 0.5 * g[a] * stress[means - 3 + s];
    }
    return force;
  }
};

}  // namespace dccast::mechanics
