#include "tests/verification/program/claims.hpp"

namespace dccast::verification {

namespace {

using mechanics::Algorithm;

// Published figures have four or five digits; ours must be the same number up to the last.
constexpr double same_digits = 5e-4;

std::string title_of(mesh::ElementKind element) {
  switch (element) {
    case mesh::ElementKind::p1:
      return "P1";
    case mesh::ElementKind::q1:
      return "Q1";
    case mesh::ElementKind::q1_bending:
      return "Q1 that bends";
  }
  return {};
}

RunRequest named(const char* name) {
  RunRequest request;
  request.name = name;
  return request;
}
RunRequest with_step(const char* name, double dt) {
  RunRequest request = named(name);
  request.dt = dt;
  return request;
}
RunRequest with_liquid(double epsilon, double delta, double beta) {
  RunRequest request = named("T1");
  request.liquid = FictitiousLiquid{epsilon, delta, beta};
  return request;
}
/// Iteration counts depend on where one stops: they are claimed at a relative residual of 1e-6,
/// where displacement and stress agree with those of 1e-10 to four digits.
RunRequest counted(Algorithm algorithm) {
  RunRequest request = with_step("T4", 0.0625);
  request.algorithm = algorithm;
  request.tolerance = 1e-6;
  return request;
}

void add_t1(std::vector<Claim>& all) {
  all.push_back(
      {"T1 direct, displacement", named("T1"), "displacement_error", Relation::at_most, 2.42e-4});
  all.push_back({"T1 direct, stress", named("T1"), "stress_error", Relation::at_most, 6.91e-3});
  all.push_back({"T1 direct, order of displacement", named("orders"), "order_t1_displacement",
                 Relation::within, 2.0, 0.05});
  all.push_back({"T1 direct, order of stress", named("orders"), "order_t1_stress", Relation::within,
                 1.0, 0.05});
  for (double epsilon : {1e-3, 1e-5}) {
    const RunRequest extended = with_liquid(epsilon, 2.0, 1.0);
    all.push_back({"T1 extended (2,1), displacement against direct", extended,
                   "displacement_error_over_direct", Relation::within, 1.0, 0.05});
    all.push_back({"T1 extended (2,1), stress against direct", extended, "stress_error_over_direct",
                   Relation::within, 1.0, 0.01});
  }
  const double epsilon[] = {1e-1, 1e-3, 1e-5}, paper[] = {0.0165, 0.350, 0.454};
  for (int i = 0; i < 3; ++i) {
    all.push_back({"T1 extended (1,2), displacement, maximum norm", with_liquid(epsilon[i], 1, 2),
                   "displacement_error_max_norm", Relation::within, paper[i], 0.15});
  }
  for (double e : epsilon) {
    all.push_back({"T1 extended (1,1), displacement, maximum norm", with_liquid(e, 1, 1),
                   "displacement_error_max_norm", Relation::within, 2.2e-3, 0.15});
  }
}

void add_t2(std::vector<Claim>& all) {
  for (double dt : {1.0, 0.1}) {
    const bool nightly = dt < 1.0;
    const RunRequest t2 = with_step("T2", dt);
    const std::string name = nightly ? "T2, dt 0.1" : "T2, dt 1";
    all.push_back({name + ", displacement", t2, "displacement_error", Relation::at_most, 1.75e-4, 0,
                   nightly});
    all.push_back({name + ", stress", t2, "stress_error", Relation::at_most, 1.25e-2, 0, nightly});
    all.push_back({name + ", stress at centroids", t2, "stress_error_at_centroids",
                   Relation::at_most, 7.4e-3, 0, nightly});
    if (nightly) {
      all.push_back({name + ", contact iterations per step", t2, "iterations_per_step",
                     Relation::at_most, 1.2, 0, nightly});
    }
  }
  RunRequest sbm = with_step("T2", 0.1);
  sbm.algorithm = Algorithm::sbm;
  all.push_back({"T2, dt 0.1, SBM, iterations per step", sbm, "iterations_per_step",
                 Relation::within, 250.0, 0.2, true});
}

struct Published {
  double dt, displacement, stress;
  bool nightly;
};

void add_square(std::vector<Claim>& all, const char* name, const std::vector<Published>& figures) {
  for (const Published& p : figures) {
    char title[60];
    std::snprintf(title, sizeof title, "%s, dt %g", name, p.dt);
    const RunRequest request = with_step(name, p.dt);
    all.push_back({std::string(title) + ", displacement", request, "displacement_error",
                   Relation::within, p.displacement, same_digits, p.nightly});
    all.push_back({std::string(title) + ", stress", request, "stress_error", Relation::within,
                   p.stress, same_digits, p.nightly});
  }
}

void add_iterations(std::vector<Claim>& all) {
  const std::pair<Algorithm, double> most[] = {{Algorithm::newton, 6.4},
                                               {Algorithm::vnbm, 31.0},
                                               {Algorithm::sbm, 208.0},
                                               {Algorithm::nbm, 69.0}};
  for (const auto& [algorithm, bound] : most) {
    all.push_back({"T4, dt 0.0625, iterations per step", counted(algorithm), "iterations_per_step",
                   Relation::at_most, bound});
  }
  RunRequest plain = with_step("T4", 0.0625);
  plain.algorithm = Algorithm::nbm;
  plain.plain = true;
  all.push_back({"T4, dt 0.0625, plain NBM must fail", plain, "", Relation::fails_at, 0.3125});
  all.push_back({"T4, all algorithms at 1e-10: largest difference", named("agreement"),
                 "largest_difference", Relation::at_most, 1e-4});
}

void add_heat(std::vector<Claim>& all) {
  all.push_back({"Stefan, similarity constant", named("stefan"), "similarity_constant",
                 Relation::within, 0.27296013, 2e-8});
  all.push_back({"Stefan, front", named("stefan"), "front_error", Relation::at_most, 0.02});
  all.push_back(
      {"Stefan, temperature [K]", named("stefan"), "temperature_error_k", Relation::at_most, 0.5});
  all.push_back({"mushy Stefan, solidus front", named("mushy-stefan"), "solidus_front_error",
                 Relation::at_most, 5e-3});
  all.push_back({"mushy Stefan, liquidus front", named("mushy-stefan"), "liquidus_front_error",
                 Relation::at_most, 5e-3});
  all.push_back({"steady strand, largest error [K]", named("strand"), "largest_temperature_error_k",
                 Relation::at_most, 0.1});
  all.push_back({"steady strand, depth of isotherms", named("strand"), "isotherm_error",
                 Relation::at_most, 1e-3});
}

constexpr mesh::ElementKind families[] = {mesh::ElementKind::p1, mesh::ElementKind::q1,
                                          mesh::ElementKind::q1_bending};

void add_exact_checks(std::vector<Claim>& all) {
  for (const auto element : families) {
    const std::string family = ", " + title_of(element);
    RunRequest patch = named("patch"), creep = named("creep");
    patch.element = creep.element = element;
    all.push_back({"patch test" + family + ", displacement", patch, "displacement_error",
                   Relation::at_most, 1e-12});
    all.push_back(
        {"patch test" + family + ", stress", patch, "stress_error", Relation::at_most, 1e-11});
    all.push_back({"creep under constant load" + family, creep, "displacement_error",
                   Relation::at_most, 1e-6});
  }
  for (const auto element : {mesh::ElementKind::q1, mesh::ElementKind::q1_bending}) {
    RunRequest modes = named("modes");
    modes.element = element;
    const std::string family = ", " + title_of(element);
    all.push_back({"deformations without energy" + family, modes, "modes_without_energy",
                   Relation::within, 3.0, 0.0});
  }
  RunRequest plate = named("plate");
  plate.element = mesh::ElementKind::q1_bending;
  all.push_back(
      {"bent plate, cells to 10 thicknesses long, four layers, " + title_of(plate.element), plate,
       "displacement_error", Relation::at_most, 2.5e-2});
  all.push_back({"bent plate, one layer at Poisson's ratio 0.4999, " + title_of(plate.element),
                 plate, "displacement_error_one_layer_nearly_incompressible", Relation::at_most,
                 1e-3});
  all.push_back({"relaxation, order in time", named("orders"), "order_relaxation_stress",
                 Relation::within, 1.0, 0.1});
  all.push_back({"T4, order in time of displacement", named("orders"), "order_t4_displacement",
                 Relation::within, 1.0, 0.1});
}

void add_axisymmetric(std::vector<Claim>& all) {
  const auto claim = [&all](const RunRequest& request, const std::string& what, const char* key,
                            Relation relation, double bound, double tolerance = 0.0) {
    all.push_back({what, request, key, relation, bound, tolerance});
  };
  for (const auto element : families) {
    RunRequest patch = named("ring-patch"), tube = named("tube");
    patch.element = tube.element = element;
    const std::string family = ", " + title_of(element);
    claim(patch, "axisymmetric patch test, displacement" + family, "displacement_error",
          Relation::at_most, 1e-12);
    claim(patch, "axisymmetric patch test, stress" + family, "stress_error", Relation::at_most,
          1e-11);
    claim(tube, "pressed tube, order of displacement" + family, "order_displacement",
          Relation::within, 2.0, 0.05);
    claim(tube, "pressed tube, order of stress" + family, "order_stress", Relation::within, 1.0,
          0.05);
  }
  // Triangles lock where metal hardly changes its volume or creeps: 2 % of the displacement and 26
  // % of the stress on this mesh.
  for (const auto element : {mesh::ElementKind::q1, mesh::ElementKind::q1_bending}) {
    RunRequest tube = named("tube"), creep = named("tube-creep");
    tube.element = creep.element = element;
    const bool bends = element == mesh::ElementKind::q1_bending;
    const std::string family = ", " + title_of(element) + ", ";
    claim(tube, "pressed tube" + family + "displacement", "displacement_error", Relation::at_most,
          bends ? 2.5e-4 : 1.5e-4);
    claim(tube, "pressed tube" + family + "displacement at Poisson's ratio 0.4999",
          "displacement_error_nearly_incompressible", Relation::at_most, bends ? 3.2e-4 : 1.7e-4);
    claim(tube, "pressed tube" + family + "stress at Poisson's ratio 0.4999",
          "stress_error_nearly_incompressible", Relation::at_most, 2.5e-2);
    claim(creep, "creeping tube" + family + "stress", "stress_error_at_centroids",
          Relation::at_most, 6e-4);
    claim(creep, "creeping tube" + family + "rate of the inner wall", "rate_error",
          Relation::at_most, 1.2e-3);
  }
}

void add_hertz(std::vector<Claim>& all) {
  const auto claim = [&all](const RunRequest& request, const std::string& what, const char* key,
                            Relation relation, double bound, double tolerance = 0.0) {
    all.push_back({"Hertz contact" + what, request, key, relation, bound, tolerance});
  };
  for (const auto element : families) {
    const bool p1 = element == mesh::ElementKind::p1;
    const std::string family = ", " + title_of(element);
    RunRequest orders = named("hertz-orders"), cycle = named("hertz-cycle");
    orders.element = cycle.element = element;
    claim(orders, family + ", half width on four meshes, in cells", "half_width_error_in_cells",
          Relation::at_most, 1.0);
    claim(orders, family + ", peak pressure", "peak_pressure_error", Relation::at_most,
          p1 ? 0.04 : 1e-4);
    claim(orders, family + ", pressure", "pressure_error", Relation::at_most, p1 ? 0.01 : 2.5e-3);
    // The pressure ends like a root: half an order less than a smooth one at the best.
    claim(orders, family + ", order of pressure", "order_pressure", Relation::within,
          p1 ? 1.0 : 1.5, 0.15);
    claim(orders, family + ", order of stress", "order_stress", Relation::within, 1.0, 0.1);
    claim(orders, family + ", what a finite body does to the pressure", "finite_body_error",
          Relation::at_most, 3e-5);
    for (const auto algorithm :
         {Algorithm::newton, Algorithm::vnbm, Algorithm::sbm, Algorithm::nbm}) {
      cycle.algorithm = algorithm;
      const std::string who = " cycle" + family + ", " + name_of(algorithm);
      claim(cycle, who + ", half width, in cells", "half_width_error_in_cells", Relation::at_most,
            1.0);
      claim(cycle, who + ", gap, reaction and their product", "complementarity_error",
            Relation::at_most, 1e-6);
      claim(cycle, who + ", reactions against the load", "load_error", Relation::at_most, 1e-8);
      claim(cycle, who + ", last step against first", "difference_after_cycle", Relation::at_most,
            1e-8);
    }
  }
  claim(named("agreement"), ", all algorithms at 1e-10: largest difference",
        "largest_difference_hertz", Relation::at_most, 1e-6);
}

}  // namespace

const std::vector<Claim>& claims() {
  static const std::vector<Claim> all = [] {
    std::vector<Claim> list;
    add_t1(list);
    add_t2(list);
    add_square(list, "T3",
               {{1e-5, 2.2865e-5, 2.5309e-5, true},
                {1e-3, 2.288e-3, 2.531e-3, false},
                {0.0625, 0.14976, 0.15941, false}});
    add_square(list, "T4",
               {{1e-5, 2.7005e-5, 2.2784e-5, true},
                {1e-3, 2.7035e-3, 2.2789e-3, false},
                {0.0625, 0.17995, 0.14408, false}});
    add_iterations(list);
    add_heat(list);
    add_exact_checks(list);
    add_axisymmetric(list);
    add_hertz(list);
    return list;
  }();
  return all;
}

}  // namespace dccast::verification
