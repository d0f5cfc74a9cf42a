#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstddef>

#include "core/base/tensors.hpp"
#include "core/fem/element.hpp"

namespace dccast::fem {

/// The bending modes of a BendingHexahedron.
///
/// The part of the displacement that is neither a translation nor a uniform gradient is, with r, s,
/// t the reference coordinates, q0 st + q1 rt + q2 rs + q3 rst (Flanagan and Belytschko 1981). Its
/// gradient has a part that is linear in the coordinate of axis c: the bending and twisting of a
/// plate normal to c. The components in the plane of the plate are kept; the strain along the
/// normal is the negative of their trace. Of q3 the stretch along each axis is kept, with minus
/// half of it along both transverse directions. All modes preserve the volume.
///
/// Units: reference coordinates and levers [1].
/// @tparam Number  double, or Lanes for the modes of several elements
template <class Number>
struct SolidBendingModes {
  /// Nodes of the cell; hourglass warps st, rt, rs, rst; bending modes; linear levers.
  static constexpr std::size_t nodes = 8, warps = 4, modes = 12, levers = 6;

  /// Weights of the nodes in q0 to q3 [1].
  std::array<std::array<Number, nodes>, warps> warp;
  /// At a point the strain of a mode is lever times amplitude times strain. Modes 3 c to 3 c + 2
  /// are those of the plate normal to axis c, modes 9 to 11 the bilinear stretches.
  struct Mode {
    SymmetricTensor<3, Number> strain;  ///< trace-free [1]
    /// Amplitude = sum of share . q over the two warps_of() the mode [1/m].
    std::array<std::array<Number, 3>, 2> share;
  };
  std::array<Mode, modes> mode;

  /// The warps that contribute to a mode: for a plate those of the other two axes.
  static constexpr std::array<std::size_t, 2> warps_of(std::size_t mode) {
    if (mode >= 9) return {3, 3};
    return {(mode / 3 + 2) % 3, (mode / 3 + 1) % 3};
  }
  /// Index of the lever of a mode: the coordinate normal to the plate, or the product of the two
  /// coordinates transverse to the stretch.
  static constexpr std::size_t lever_of(std::size_t mode) { return mode < 9 ? mode / 3 : mode - 6; }
  /// The levers at a point of the reference cell, r, s, t, st, rt, rs, before their volume means
  /// are subtracted.
  static std::array<double, levers> lever(const std::array<double, 3>& p) {
    return {p[0], p[1], p[2], p[1] * p[2], p[0] * p[2], p[0] * p[1]};
  }
};

/// The modes of a cell. @see SolidBendingModes
struct SolidBending : SolidBendingModes<double> {
  /// Leaves all members without a value.
  SolidBending() = default;
  /// @param corner  (node) coordinates [m]
  explicit SolidBending(const std::array<Eigen::Vector3d, nodes>& corner) {
    const auto reference = Q1Hexahedron::shape_gradient({0.0, 0.0, 0.0});
    Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();  // columns dx/dr, dx/ds, dx/dt at the centre
    for (std::size_t i = 0; i < nodes; ++i) {
      axes += corner[i] * Eigen::Map<const Eigen::RowVector3d>(reference[i].data());
    }
    const Eigen::Matrix3d normals = axes.inverse();  // rows: gradients of r, s, t

    set_warps(corner, reference, normals);
    for (std::size_t across = 0; across < 3; ++across) set_plate(across, axes, normals);
    for (std::size_t along = 0; along < 3; ++along) {
      set_stretch(along, axes.col(static_cast<int>(along)));
    }
  }

private:
  /// (node, direction) derivatives of the shape functions [1/m].
  using Gradients = std::array<std::array<double, 3>, nodes>;

  /// Weights gamma_i of the nodes in q = sum of gamma_i u_i, orthogonal to all uniform gradients
  /// (Flanagan and Belytschko 1981).
  void set_warps(const std::array<Eigen::Vector3d, nodes>& corner, const Gradients& reference,
                 const Eigen::Matrix3d& normals) {
    for (std::size_t w = 0; w < warps; ++w) {
      Eigen::Vector3d position_warp = Eigen::Vector3d::Zero();  // q of the coordinates themselves
      for (std::size_t i = 0; i < nodes; ++i) {
        warp[w][i] = 0.125;
        for (std::size_t d = 0; d < 3; ++d) {
          if (d != w) warp[w][i] *= detail::corner[i][d];
        }
        position_warp += warp[w][i] * corner[i];
      }

      const Eigen::Vector3d share = normals * position_warp;
      for (std::size_t i = 0; i < nodes; ++i) {
        warp[w][i] -= share.dot(Eigen::Map<const Eigen::Vector3d>(reference[i].data()));
      }
    }
  }

  /// With q_b r_a r_c and q_a r_b r_c the gradient linear in r_c is q_b (x) n_a + q_a (x) n_b,
  /// where n_a and n_b are the gradients of r_a and r_b.
  void set_plate(std::size_t c, const Eigen::Matrix3d& axes, const Eigen::Matrix3d& normals) {
    const std::size_t a = (c + 1) % 3, b = (c + 2) % 3;
    const Eigen::Vector3d normal = normals.row(static_cast<int>(c)).normalized();
    const Eigen::Vector3d e1 = axes.col(static_cast<int>(a)).normalized(), e2 = normal.cross(e1);
    const Eigen::Vector3d na = normals.row(static_cast<int>(a));
    const Eigen::Vector3d nb = normals.row(static_cast<int>(b));
    const auto add = [&](std::size_t number, const Eigen::Matrix3d& strain,
                         auto&& amplitude_share) {
      Mode& m = mode[3 * c + number];
      m.strain = tensor(strain);
      m.share = {components(amplitude_share(na)), components(amplitude_share(nb))};
    };

    // Two stretches in the plane of the plate, and its shear.
    const Eigen::Matrix3d opposite = normal * normal.transpose();
    const Eigen::Matrix3d shear = e1 * e2.transpose();
    add(0, e1 * e1.transpose() - opposite,
        [&](const Eigen::Vector3d& n) { return Eigen::Vector3d(e1.dot(n) * e1); });
    add(1, e2 * e2.transpose() - opposite,
        [&](const Eigen::Vector3d& n) { return Eigen::Vector3d(e2.dot(n) * e2); });
    add(2, shear + shear.transpose(), [&](const Eigen::Vector3d& n) {
      return Eigen::Vector3d(0.5 * (e2.dot(n) * e1 + e1.dot(n) * e2));
    });
  }

  /// A stretch along an axis with minus half of it along both transverse directions.
  void set_stretch(std::size_t along, const Eigen::Vector3d& axis) {
    Mode& m = mode[9 + along];
    const Eigen::Vector3d t = axis.normalized();
    m.strain = tensor(1.5 * t * t.transpose() - 0.5 * Eigen::Matrix3d::Identity());
    m.share = {components(axis / axis.squaredNorm()), {}};
  }

  /// Components of a vector as an array.
  static std::array<double, 3> components(const Eigen::Vector3d& v) { return {v(0), v(1), v(2)}; }
  /// Components of a symmetric matrix.
  static SymmetricTensor<3> tensor(const Eigen::Matrix3d& t) {
    return {{t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(1, 2), t(0, 2)}};
  }
};

}  // namespace dccast::fem
