#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/statistics/robust_search.hpp"
#include "dccast/v1/study.pb.h"
#include "proto/case_file/recipe_numbers.hpp"

namespace dccast::studies {

/// Designs of a recipe plan: vectors of its numbers, scaled to 0..1 between their ends, and the
/// changes of the case that they stand for.
class RecipeSpace {
public:
  /// @param draft  the case at the quality of draft
  /// @param plan  numbers with their ranges, data, band
  RecipeSpace(const v1::Case& draft, const v1::RecipePlan& plan);

  int numbers() const { return plan_.numbers_size(); }
  int data() const { return plan_.data_size(); }
  /// Value of one number of a design. @param which  index in the plan
  double number(int which, const Eigen::RowVectorXd& design) const {
    return ends_[which].low + design(which) * (ends_[which].high - ends_[which].low);
  }
  /// A recipe as a point of the unit cube.
  Eigen::RowVectorXd design(const case_file::Recipe& recipe) const;
  /// Nearest design within the limits on the rates of speed and water, and with no filling beyond
  /// the hold: ramps become longer, and if they cannot, the level of the run moves to that of the
  /// start.
  Eigen::RowVectorXd permitted(const Eigen::RowVectorXd& design) const;
  /// The changes of the case that make it a recipe.
  std::vector<v1::CaseChange> changes(const Eigen::RowVectorXd& design) const;
  /// Time from the first metal to the cast length of the case [s].
  double casting_time_s(const Eigen::RowVectorXd& design) const;
  /// The changes that give the data of the case the values of a draw.
  std::vector<v1::CaseChange> data_changes(const Eigen::RowVectorXd& data) const;
  /// (casting, data) castings, 0 to 1: a Latin hypercube, or some of those that the line of the
  /// plan leaves possible.
  Eigen::MatrixXd castings(int count, std::uint64_t seed) const;
  const v1::RecipePlan& plan() const { return plan_; }

private:
  /// A number of the recipe with the ends of its range, in SI units.
  struct Ends {
    case_file::RecipeNumber number;
    double low, high;
  };
  /// The recipe of a point, with ramps that keep the permitted rates.
  case_file::Recipe recipe(const Eigen::RowVectorXd& design) const;
  /// Ends of a number; null if the case does without it.
  const Ends* ends_of(case_file::RecipeNumber number) const;
  /// Lengthens a ramp that changes speed or water faster than `rate` [unit/s], or shortens its
  /// step.
  /// @param start  number of the value at the start; the next two are those of the run and the ramp
  void keep_rate(case_file::Recipe& recipe, case_file::RecipeNumber start, double rate) const;

  v1::Case draft_;
  v1::RecipePlan plan_;
  std::vector<Ends> ends_;
};

/// Outcome of a draft that has ended.
struct RecipeRun {
  Eigen::RowVectorXd place;      ///< numbers, then data
  std::optional<double> curl_m;  ///< empty if the run has no valid end
  bool danger = false;           ///< set, too, if the run has no valid end

  /// Whether the run is outside the band or dangerous. @param scale  factor on the curl
  bool lost(const v1::RecipePlan& plan, double scale) const;
};

/// Outcome of a run for a recipe; empty if the run was cancelled or ended for a reason unrelated to
/// the casting.
std::optional<RecipeRun> recipe_run(const v1::StudyRun& run, int monitor, Eigen::RowVectorXd place);

/// Codes of a run's dangers, including that of its failure.
std::vector<std::string> dangers_of(const v1::StudyRun& run);

/// Proposes candidates with surfaces over the drafts.
class RecipeSearch {
public:
  /// @param scale  ratio of the curl at full quality to that of a draft
  /// @throws std::runtime_error  too few drafts with a valid curl
  RecipeSearch(std::shared_ptr<const RecipeSpace> space, const std::vector<RecipeRun>& runs,
               double scale);
  RecipeSearch(const RecipeSearch&) = delete;

  /// Front of all designs, least risk first. @param seed  of the search
  std::vector<statistics::ScoredDesign> candidates(std::uint64_t seed) const;
  /// Risk, curl and time of a recipe, by the surfaces.
  statistics::DesignScore score(const Eigen::RowVectorXd& design) const;
  /// Risk of a design. @param castings  runs at the design of which the surfaces do not know
  statistics::Share risk(const statistics::DesignScore& score,
                         const std::vector<RecipeRun>& castings) const;
  /// Writes measures of the surfaces' accuracy.
  void describe(v1::RecipeFound& found) const;
  /// Curl at full quality relative to draft, at the case itself [1].
  double scale() const { return scale_; }

private:
  std::shared_ptr<const RecipeSpace> space_;
  double scale_;
  int runs_ = 0, dangers_ = 0;
  std::optional<statistics::GaussianProcess> curl_;
  std::optional<statistics::Classifier> danger_;
  double error_m_ = 0.0;
  statistics::DesignProblem problem_;
};

}  // namespace dccast::studies
