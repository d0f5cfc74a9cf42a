#pragma once

#include <cmath>

#include "core/mechanics/element_forms.hpp"

namespace dccast::mechanics {

/// The forms of the hexahedron whose strain is its mean and bending modes (fem::SolidBending). The
/// modes keep the volume, so that the mean dilatation is that of every point.
///
/// Between strain and stiffness stand 18 generalised strains: the mean in its six components and the
/// amplitudes of twelve modes.
template <>
struct ElementForms<fem::BendingHexahedron, true> : ElementFormsBase<fem::BendingHexahedron> {
  using Bending = fem::SolidBending;
  static constexpr std::size_t modes = Bending::modes, levers = Bending::levers,
                               generalised = 6 + modes;

  static Tensor strain(const Cell& c, std::size_t q, const Vectors& v) {
    return strain_deviators(c, v)[q].add_identity(mean_dilatation(c, v) / 3.0);
  }

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

  static Vectors forces(const Cell& c, Responses response, Pressures pressure) {
    Tensor sum;  // of the stress over the volume [N m], its deviator
    std::array<Tensor, levers> moment{};
    double pressures = 0.0;
    for (std::size_t q = 0; q < points; ++q) {
      const double weight = c.point[q].weight;
      sum.add(weight, response[q].deviator);
      pressures += weight * pressure[q];
      for (std::size_t l = 0; l < levers; ++l) {
        moment[l].add(weight * c.point[q].lever[l], response[q].deviator);
      }
    }
    sum.add_identity(pressures);
    const auto of_warp = forces_of_warps(c, moment);
    Vectors force;
    for (std::size_t i = 0; i < nodes; ++i) {
      const auto& g = c.mean_gradient[i];
      for (std::size_t a = 0; a < dim; ++a) {
        double f = sum.at(a, 0) * g[0] + sum.at(a, 1) * g[1] + sum.at(a, 2) * g[2];
        for (std::size_t w = 0; w < Bending::warps; ++w) {
          f += c.bending.warp[w][i] * of_warp[w][a];
        }
        force[i][a] = f;
      }
    }
    return force;
  }

  static Matrix stiffness(const Cell& c, Responses response, double bulk_modulus) {
    const Moduli d = generalised_moduli(c, response, bulk_modulus);
    const Amplitudes b = amplitudes(c);
    Amplitudes stress{};  // generalised, of unit displacements
    for (std::size_t m = 0; m < generalised; ++m) {
      for (std::size_t n = 0; n < generalised; ++n) {
        for (std::size_t u = 0; u < unknowns; ++u) stress[m][u] += d[m][n] * b[n][u];
      }
    }
    Matrix k{};
    for (std::size_t i = 0; i < nodes; ++i) {
      const std::size_t end = dim * (i + 1);  // of what is needed of the lower triangle
      for (std::size_t row = dim * i; row < end; ++row) {
        for (std::size_t m = 0; m < generalised; ++m) {
          const double factor = b[m][row];
          for (std::size_t u = 0; u < end; ++u) k[row * unknowns + u] += factor * stress[m][u];
        }
      }
    }
    return k;
  }

private:
  using Moduli = std::array<std::array<double, generalised>, generalised>;
  /// Generalised strains of unit displacements [1/m].
  using Amplitudes = std::array<std::array<double, unknowns>, generalised>;
  /// A tensor whose shear is scaled so that products of tensors are products of vectors.
  using Scaled = std::array<double, 6>;

  static Scaled scaled(const Tensor& t) {
    constexpr double root = 1.41421356237309504880;  // two shear components in a product
    return {t[0], t[1], t[2], root * t[3], root * t[4], root * t[5]};
  }
  static double dot(const Scaled& a, const Scaled& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }

  static Tensor mean_strain(const Cell& c, const Vectors& v) {
    Tensor mean;
    for (std::size_t i = 0; i < nodes; ++i) {
      const auto& g = c.mean_gradient[i];
      for (std::size_t a = 0; a < dim; ++a) mean[a] += g[a] * v[i][a];
      mean[3] += 0.5 * (g[0] * v[i][1] + g[1] * v[i][0]);
      mean[4] += 0.5 * (g[1] * v[i][2] + g[2] * v[i][1]);
      mean[5] += 0.5 * (g[0] * v[i][2] + g[2] * v[i][0]);
    }
    return mean;
  }

  /// What a unit of each lever adds to the strain.
  static std::array<Tensor, levers> strains_of_levers(const Cell& c, const Vectors& v) {
    std::array<std::array<double, 3>, Bending::warps> q{};
    for (std::size_t w = 0; w < q.size(); ++w) {
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) q[w][a] += c.bending.warp[w][i] * v[i][a];
      }
    }
    std::array<Tensor, levers> linear{};
    for (std::size_t m = 0; m < modes; ++m) {
      const Bending::Mode& mode = c.bending.mode[m];
      double amplitude = 0.0;
      for (std::size_t j = 0; j < 2; ++j) {
        for (std::size_t a = 0; a < dim; ++a) amplitude += mode.share[j][a] * q[mode.warp[j]][a];
      }
      linear[Bending::lever_of(m)].add(amplitude, mode.strain);
    }
    return linear;
  }

  static std::array<std::array<double, 3>, Bending::warps> forces_of_warps(
      const Cell& c, const std::array<Tensor, levers>& moment) {
    std::array<std::array<double, 3>, Bending::warps> force{};
    for (std::size_t m = 0; m < modes; ++m) {
      const Bending::Mode& mode = c.bending.mode[m];
      const double of_mode = dot(scaled(moment[Bending::lever_of(m)]), scaled(mode.strain));
      for (std::size_t j = 0; j < 2; ++j) {
        for (std::size_t a = 0; a < dim; ++a) {
          force[mode.warp[j]][a] += of_mode * mode.share[j][a];
        }
      }
    }
    return force;
  }

  /// Deviators of unit generalised strains.
  static std::array<Scaled, generalised> unit_strains(const Cell& c) {
    std::array<Scaled, generalised> strain;
    for (std::size_t n = 0; n < 6; ++n) {
      Tensor t;
      t[n] = 1.0;
      strain[n] = scaled(t.deviator());
    }
    for (std::size_t m = 0; m < modes; ++m) strain[6 + m] = scaled(c.bending.mode[m].strain);
    return strain;
  }
  /// Number of the lever of a generalised strain, zero of the mean.
  static constexpr std::size_t lever_of(std::size_t n) {
    return n < 6 ? 0 : 1 + Bending::lever_of(n - 6);
  }

  static Moduli generalised_moduli(const Cell& c, Responses response, double bulk_modulus) {
    const auto strain = unit_strains(c);
    Moduli d{};
    double shear[1 + levers][1 + levers] = {};  // moments of twice the shear modulus
    for (std::size_t q = 0; q < points; ++q) {
      double lever[1 + levers] = {1.0};
      for (std::size_t l = 0; l < levers; ++l) lever[1 + l] = c.point[q].lever[l];
      const double stiff = 2.0 * c.point[q].weight * response[q].shear;
      for (std::size_t l = 0; l <= levers; ++l) {
        for (std::size_t m = 0; m <= levers; ++m) shear[l][m] += stiff * lever[l] * lever[m];
      }
      const PointResponse<3>& r = response[q];
      if (r.normal != 0.0 && r.norm > 0.0) {
        add_softening(d, c.point[q].weight * r.normal / (r.norm * r.norm), scaled(r.deviator),
                      strain, lever);
      }
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

  /// Adds what creep takes along the stress at a point, to the lower triangle.
  static void add_softening(Moduli& d, double normal, const Scaled& stress,
                            const std::array<Scaled, generalised>& strain,
                            const double (&lever)[1 + levers]) {
    std::array<double, generalised> along;
    for (std::size_t n = 0; n < generalised; ++n) {
      along[n] = lever[lever_of(n)] * dot(stress, strain[n]);
    }
    for (std::size_t n = 0; n < generalised; ++n) {
      const double factor = normal * along[n];
      for (std::size_t m = 0; m <= n; ++m) d[n][m] += factor * along[m];
    }
  }

  static Amplitudes amplitudes(const Cell& c) {
    Amplitudes b{};
    constexpr std::size_t pair[3][2] = {{0, 1}, {1, 2}, {0, 2}};  // of the shears xy, yz, xz
    for (std::size_t i = 0; i < nodes; ++i) {
      const auto& g = c.mean_gradient[i];
      for (std::size_t a = 0; a < dim; ++a) {
        b[a][dim * i + a] = g[a];
        b[3 + a][dim * i + pair[a][0]] = 0.5 * g[pair[a][1]];
        b[3 + a][dim * i + pair[a][1]] = 0.5 * g[pair[a][0]];
      }
    }
    for (std::size_t m = 0; m < modes; ++m) {
      const Bending::Mode& mode = c.bending.mode[m];
      for (std::size_t i = 0; i < nodes; ++i) {
        const double w0 = c.bending.warp[mode.warp[0]][i], w1 = c.bending.warp[mode.warp[1]][i];
        for (std::size_t a = 0; a < dim; ++a) {
          b[6 + m][dim * i + a] = w0 * mode.share[0][a] + w1 * mode.share[1][a];
        }
      }
    }
    return b;
  }
};

}  // namespace dccast::mechanics
