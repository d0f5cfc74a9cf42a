#include "tests/verification/program/discussion.hpp"

#include <algorithm>

#include "tests/verification/mechanics/paper_tests.hpp"
#include "tests/verification/program/plot.hpp"

namespace dccast::verification {

std::string contents_section() {
  Table table;
  table.title = "The paper, table by table and figure by figure";
  table.columns = {"paper", "here", "difference and reason, or why not"};
  table.rows = {
      {"Table 1", "table below",
       "The paper's displacements are maximum norms; in that norm ours are within 15 %. Its "
       "stresses are in neither of our norms, and it names none."},
      {"Table 2", "table below", "As table 1: 2.5e-3 for 2.2e-3, whatever epsilon is."},
      {"Table 3", "table below",
       "Ours are smaller: the cut of the cells decides (T1 in tests/verification/README.md)."},
      {"Table 4", "table below",
       "Less than half the displacement error: the thermal strain is the exact integral, the "
       "paper's is summed by steps. Its stress error is the one at centroids."},
      {"Table 5", "table below",
       "At dt = 1e-5 s 2.29e-5 for 2.62e-5 in the displacement and 2.53e-5 for 1.24e-5 in the "
       "stress. The methods agree with each other in both; why the two schemes do not is not "
       "known."},
      {"Table 6", "table below",
       "2.70e-5 for 2.92e-5, and 2.28e-5 for 1.35e-5 in the stress: as table 5."},
      {"Table 7", "table below",
       "The paper's methods have different errors at one step: stopping errors, and for NBM "
       "smaller steps. Ours solve one discrete problem."},
      {"Table 8", "table below",
       "As table 7. The default, Newton's method with the consistent tangent, is not in the "
       "paper."},
      {"Tables 9, 10", "cases/alloys/paper.toml", "Data, taken over digit by digit."},
      {"Table 11", "table below; `dccast-verify table 11 --slab` in three dimensions",
       "The paper's slab and thermal data are not printed: seconds and iterations compare methods, "
       "not machines."},
      {"Figures 1 to 3", "-", "Photographs and schemes of a plant: there is nothing to compute."},
      {"Figures 4, 5, 7, 8, 12, 15", "-",
       "Schemes of domains; the data of the tests stand in tests/verification/README.md."},
      {"Figure 6", "chart below",
       "The paper sketches three stages; its law has the first two, elastic strain and secondary "
       "creep, and so has ours."},
      {"Figures 9 to 11", "pictures below",
       "The scales of the paper's pictures cannot be read in our copy."},
      {"Figure 13", "pictures below",
       "As figures 9 to 11; errors against the exact solution stand in table 4."},
      {"Figure 14", "-", "A flow chart of NBM; ours is core/mechanics/nbm.cpp."},
      {"Figures 16, 18, 20", "pictures below",
       "The paper has tetrahedra; ours are hexahedra in rows, which grow at the top and are merged "
       "below. Figure 20 has the paper's number of triangles."},
      {"Figure 17", "pictures below",
       "35 mm computed and 38 mm measured at 250 s, on a slab whose size is not printed."},
      {"Figure 19", "chart below", "The paper's mould is not printed; ours is assumed."},
      {"Figure 21", "pictures below",
       "The paper fitted its heat to measurements that are not printed; isotherms are shown as a "
       "field."}};
  return to_html(table);
}

std::string differences_section() {
  const char* sentences[] = {
      "<b>NBM converges in our table 11, and not always in the paper.</b> The likely reason: a "
      "step "
      "of the multiplier is shortened until its distance from the law falls, with the displacement "
      "solved for each trial, and the parameter is 2 mu dt element by element, so that newly "
      "frozen "
      "elements do not share one with the others. The paper has 1 in scaled stresses. Plain NBM "
      "fails here too (T4 at t = 0.3125 s).",
      "<b>VNBM is slower than SBM in table 5 and no faster in table 6.</b> With q = 6 the "
      "eigenvalues "
      "of theorem 2 differ by q - 1 = 5, and its parameter contracts by (sqrt(5) - 1) / (sqrt(5) + "
      "1) "
      "= 0.38 at best, however short the step is. At dt = 1e-5 s hardly anything creeps in a step, "
      "and "
      "a constant contracts faster (12 iterations for 33 in table 5). In castings, where elements "
      "differ, VNBM wins (table 11).",
      "<b>Matrix-valued parameters</b>, the best choice in theory (Gallardo and others), are built "
      "neither in the paper nor here: the consistent tangent of Newton's method does what they "
      "would.",
      "<b>q = 6 lies at the edge of theorem 1</b>, which asks for q below 6. T3 and T4 have q = 6 "
      "and "
      "converge at first order in time: nothing happens at that edge in the discrete problem.",
      "<b>Two and three dimensions.</b> The paper wants to show a good agreement of its section "
      "with "
      "its slab. Ours do not agree: compare the curls of figures 17 and 21 at 145 s. The corner of "
      "a "
      "slab also bends along the wide face, a direction that the section does not have."};
  std::string out = "<section><h2>Where the paper and the product differ</h2><ul>";
  for (const char* sentence : sentences) out += std::string("<li>") + sentence + "</li>";
  return out + "</ul></section>\n";
}

std::string deformed_square_section() {
  const DeformedSquare square = deform_t2(40);
  const auto largest = [](const std::vector<double>& v) { return *std::ranges::max_element(v); };
  return "<section><h2>T2 at 200 s (the paper's figure 13)</h2><p class=\"setup\">40 x 40 "
         "quadrilaterals, steps of 10 s, displacements to scale.</p><div class=\"plots\">" +
         field_svg("displacement on the deformed square", square.mesh, square.shift,
                   largest(square.shift), "modulus [m]") +
         field_svg("von Mises' stress on the deformed square", square.mesh, square.mises,
                   largest(square.mises), "[Pa]") +
         "</div></section>\n";
}

}  // namespace dccast::verification
