#pragma once

#include <vector>

/// Exact solutions of heat conduction with solidification, each with its own root finder. Units SI
/// and °C.
namespace dccast::verification {

/// Two-phase Stefan problem of a half space: liquid at `initial`, wall at `wall` from t = 0, change
/// of phase at one temperature. The default is the aluminium of the casting cases.
struct StefanData {
  double wall = 580.0;                                            ///< [°C]
  double initial = 740.0;                                         ///< [°C]
  double change = 660.0;                                          ///< [°C]
  double solid_conductivity = 210.0, liquid_conductivity = 95.0;  ///< [W/(m K)]
  double solid_capacity = 3.0e6, liquid_capacity = 2.58e6;        ///< rho c [J/(m3 K)]
  double latent_heat = 1.08048e9;                                 ///< [J/m3]
};

/// Neumann's solution: front at 2 lambda sqrt(a_s t).
class NeumannSolution {
public:
  explicit NeumannSolution(const StefanData& stefan);
  double similarity_constant() const { return lambda_; }  ///< [1]
  double front(double time) const;                        ///< [m]
  double temperature(double depth, double time) const;    ///< [°C] at a depth [m]

private:
  StefanData stefan_;
  double solid_diffusivity_, liquid_diffusivity_;
  double lambda_ = 0.0;
};

/// The same half space solidifying over an interval: enthalpy and conductivity piecewise linear and
/// piecewise constant in solid, mush and liquid.
struct MushyStefanData {
  double wall = 560.0, initial = 700.0;      ///< [°C]
  double solidus = 620.0, liquidus = 649.0;  ///< [°C]
  double solid_conductivity = 210.0, mushy_conductivity = 150.0, liquid_conductivity = 95.0;
  double solid_capacity = 3.0e6, liquid_capacity = 2.58e6;  ///< rho c [J/(m3 K)]
  double latent_heat = 1.08048e9;                           ///< [J/m3] over the interval
  /// rho c of the mush with the latent heat spread over the interval [J/(m3 K)].
  double mushy_capacity() const {
    return 0.5 * (solid_capacity + liquid_capacity) + latent_heat / (liquidus - solidus);
  }
};

/// Similarity solution with two fronts, where the temperature is at solidus and at liquidus; the
/// flux is continuous at both because the enthalpy is.
class MushySolution {
public:
  explicit MushySolution(const MushyStefanData& mushy);
  double solidus_front(double time) const;              ///< [m]
  double liquidus_front(double time) const;             ///< [m]
  double temperature(double depth, double time) const;  ///< [°C]

private:
  double liquidus_similarity(double solidus_similarity) const;
  double mushy_amplitude(double solidus_similarity) const;
  double flux_defect(double solidus_similarity) const;

  MushyStefanData mushy_;
  double solid_root_, mushy_root_, liquid_root_;  ///< square roots of the diffusivities
  double solidus_similarity_ = 0.0, liquidus_similarity_ = 0.0;  ///< depth / (2 sqrt t)
};

/// Steady strand that leaves its metal level at a speed: (k T')' = V dH/dx, x downwards from the
/// level, temperatures given at both ends, H(T) linear between points.
struct StrandData {
  double conductivity = 180.0;        ///< k [W/(m K)]
  double speed = 1e-3;                ///< V [m/s]
  double length = 0.15;               ///< [m]
  double top_temperature = 680.0;     ///< [°C] at x = 0
  double bottom_temperature = 100.0;  ///< [°C] at x = length
  /// Points of H(T), both increasing [°C, J/m3]; the end pieces are continued as they are.
  std::vector<double> temperature{0.0, 620.0, 649.0, 700.0};
  std::vector<double> enthalpy{0.0, 1.674e9, 2.746e9, 2.874e9};
};

/// k T' - V H is the same at every depth; that makes x(T) a sum of logarithms.
class StrandSolution {
public:
  explicit StrandSolution(const StrandData& strand);
  double depth(double temperature) const;  ///< [m] below the level; falls as T rises
  double temperature(double depth) const;  ///< [°C]
  /// V H - k T' [W/m2]: the heat that passes every depth downwards.
  double heat_flow() const;

private:
  double depth_for(double temperature, double excess) const;

  StrandData strand_;
  double excess_ = 0.0;  ///< -k T' at the top [W/m2]
};

/// H(T) of StrandData: linear between its points, its end pieces continued.
double strand_enthalpy(const StrandData& strand, double temperature);

}  // namespace dccast::verification
