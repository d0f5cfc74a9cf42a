#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/statistics/robust_search.hpp"
#include "dccast/v1/study.pb.h"
#include "proto/case_file/recipe_numbers.hpp"

namespace dccast::studies {

/// The designs of a recipe plan: its numbers, 0 to 1 between their ends, and what they make of the
/// case.
class RecipeSpace {
public:
  RecipeSpace(const v1::Case& draft, const v1::RecipePlan& plan);

  int numbers() const { return plan_.numbers_size(); }
  int data() const { return plan_.data_size(); }
  /// One of the numbers. @param which  from 0, as in the plan
  double number(int which, const Eigen::RowVectorXd& design) const {
    return ends_[which].low + design(which) * (ends_[which].high - ends_[which].low);
  }
  Eigen::RowVectorXd design(const case_file::Recipe& recipe) const;
  /// Within the limits of the rates of speed and water and with no filling beyond the hold: ramps
  /// get longer, and where they cannot the level of the run comes nearer to that of the start.
  Eigen::RowVectorXd permitted(const Eigen::RowVectorXd& design) const;
  std::vector<v1::CaseChange> changes(const Eigen::RowVectorXd& design) const;
  /// From the first metal to the cast length of the case [s].
  double casting_time_s(const Eigen::RowVectorXd& design) const;
  std::vector<v1::CaseChange> data_changes(const Eigen::RowVectorXd& data) const;
  const v1::RecipePlan& plan() const { return plan_; }

private:
  struct Ends {
    case_file::RecipeNumber number;
    double low, high;
  };
  case_file::Recipe recipe(const Eigen::RowVectorXd& design) const;
  const Ends* ends_of(case_file::RecipeNumber number) const;
  void keep_rate(case_file::Recipe& recipe, case_file::RecipeNumber start, double rate) const;

  v1::Case draft_;
  v1::RecipePlan plan_;
  std::vector<Ends> ends_;
};

/// A draft that has ended.
struct RecipeRun {
  Eigen::RowVectorXd place;      ///< numbers, then data
  std::optional<double> curl_m;  ///< empty: the run has no valid end
  bool danger = false;           ///< also where it did not get to a valid end

  /// Outside the band or with a danger. @param scale  of the curl
  bool lost(const v1::RecipePlan& plan, double scale) const;
};

/// What a run that has ended means for a recipe; empty for one that was cancelled or that ended for
/// a reason outside of the casting.
std::optional<RecipeRun> recipe_run(const v1::StudyRun& run, int monitor, Eigen::RowVectorXd place);

/// Codes of the dangers of a run, those of its failure among them.
std::vector<std::string> dangers_of(const v1::StudyRun& run);

/// Candidates by surfaces over the drafts there are.
class RecipeSearch {
public:
  /// @param scale  curl at full quality over that of a draft
  /// @throws std::runtime_error  too few drafts with a valid curl
  RecipeSearch(std::shared_ptr<const RecipeSpace> space, const std::vector<RecipeRun>& runs,
               double scale);
  RecipeSearch(const RecipeSearch&) = delete;

  /// From the front of all designs, least risk first. @param seed  of the search
  std::vector<statistics::ScoredDesign> candidates(std::uint64_t seed) const;
  statistics::DesignScore score(const Eigen::RowVectorXd& design) const;
  /// With castings at the design. @param castings  that the surfaces do not know
  statistics::Share risk(const statistics::DesignScore& score,
                         const std::vector<RecipeRun>& castings) const;
  /// Writes how far the surfaces may be trusted.
  void describe(v1::RecipeFound& found) const;
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
