#pragma once

// Integrals over a FixedBody; included by fixed_body.hpp.

namespace dccast::verification {

template <class Element>
void FixedBody<Element>::add_body_force(const VectorField& force) {
  static_assert(dimension == 2, "only sections have integration points");
  for (int e = 0; e < mesh.elements(); ++e) {
    const int* node = mesh.nodes_of(e);
    for (const IntegrationPoint& point : integration_points(mesh, e)) {
      const Vector2 f = force(point.x, point.y);
      for (std::size_t i = 0; i < Element::nodes; ++i) {
        for (std::size_t d = 0; d < 2; ++d) {
          problem.external_force[2 * std::size_t(node[i]) + d] +=
              radius_factor(point.x) * point.weight * point.shape[i] * f[d];
        }
      }
    }
  }
}

/// Squares of a difference and of the exact value, summed with their weights.
struct RelativeNorm {
  double difference = 0.0, exact = 0.0;
  void add(double weight, double computed, double reference) {
    difference += weight * (computed - reference) * (computed - reference);
    exact += weight * reference * reference;
  }
  void add(double weight, const PlaneStress& computed, const PlaneStress& reference) {
    for (std::size_t c = 0; c < PlaneStress::components; ++c) {
      add((c < 3 ? 1.0 : 2.0) * weight, computed[c], reference[c]);
    }
  }
  double value() const {
    return exact > 0.0 ? std::sqrt(difference / exact) : std::sqrt(difference);
  }
};

template <class Element>
Errors relative_errors(const FixedBody<Element>& body,
                       const std::function<Vector2(double, double)>& displacement,
                       const std::function<PlaneStress(double, double)>& stress) {
  RelativeNorm u_norm, s_norm, centroid_norm;
  const std::vector<PlaneStress> computed = body.stresses();
  for (int e = 0; e < body.mesh.elements(); ++e) {
    const int* node = body.mesh.nodes_of(e);
    PlaneStress mean;
    double area = 0.0;
    for (const IntegrationPoint& point : integration_points(body.mesh, e)) area += point.weight;
    for (std::size_t q = 0; q < Element::points; ++q) {
      mean.add(body.forms.geometry().cell(e).point[q].weight / body.forms.geometry().cell(e).volume,
               computed[std::size_t(e) * Element::points + q]);
    }
    Vector2 centroid{};
    for (const IntegrationPoint& point : integration_points(body.mesh, e)) {
      const Vector2 exact = displacement(point.x, point.y);
      for (std::size_t d = 0; d < 2; ++d) {
        double u = 0.0;
        for (std::size_t i = 0; i < Element::nodes; ++i) {
          u += point.shape[i] * body.displacement()[2 * std::size_t(node[i]) + d];
        }
        u_norm.add(point.weight, u, exact[d]);
        centroid[d] += point.weight * (d == 0 ? point.x : point.y) / area;
      }
      s_norm.add(point.weight, mean, stress(point.x, point.y));
    }
    centroid_norm.add(area, mean, stress(centroid[0], centroid[1]));
  }
  return {u_norm.value(), s_norm.value(), centroid_norm.value()};
}

}  // namespace dccast::verification
