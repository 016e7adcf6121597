#include <algorithm>
#include <cmath>

#include "detail/number_text.hpp"
#include "detail/svg_chart.hpp"
#include "graspctx/io/report_file.hpp"
#include "graspctx/version.hpp"

namespace graspctx {

namespace {

using detail::decimal_text;
using detail::escaped;
using detail::SvgChart;

constexpr const char* page_style =
    "body { font: 15px/1.45 sans-serif; color: #222; background: #fff; max-width: 920px; margin: 2em auto; "
    "padding: 0 1em; }\n"
    "h1 { font-size: 1.5em; }\nh2 { font-size: 1.1em; margin: 0 0 .3em; }\n"
    "table { border-collapse: collapse; margin: .6em 0 1.4em; }\n"
    "th, td { padding: .2em .7em; border-bottom: 1px solid #ddd; text-align: right; vertical-align: top; }\n"
    "th:first-child, td:first-child { text-align: left; }\n"
    "table.facts td { text-align: left; }\n"
    ".figures { display: flex; flex-wrap: wrap; gap: 1.2em 2em; }\n"
    "section { width: 430px; max-width: 100%; break-inside: avoid; }\n"
    "p.note { color: #555; font-size: .9em; margin: .2em 0 1em; }\n"
    "small { color: #555; }\n";

std::string figure(double value, int decimals = 3) {
  return std::isnan(value) ? "–" : decimal_text(value, decimals);
}

std::string percent(double share) {
  return decimal_text(100 * share, 0) + " %";
}

/// "0.812 [0.771, 0.846]", the interval small.
std::string with_interval(double value, const Interval& interval) {
  if (std::isnan(value)) return figure(value);
  return figure(value) + " <small>[" + figure(interval.low) + ", " + figure(interval.high) + "]</small>";
}

/// The cells are HTML, the header is text.
std::string table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table>\n<tr>";
  for (const std::string& name : header) html += "<th>" + escaped(name) + "</th>";
  html += "</tr>\n";
  for (const auto& row : rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += "<td>" + cell + "</td>";
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string facts_table(const ReportHead& head) {
  std::string html = "<table class=\"facts\">\n";
  for (const auto& [name, value] : head.facts) {
    html += "<tr><td>" + escaped(name) + "</td><td>" + escaped(value) + "</td></tr>\n";
  }
  return html + "</table>\n";
}

std::string figures_table(const EvaluationReport& report) {
  std::vector<std::vector<std::string>> rows;
  for (const ClassEvaluation& row : report.classes) {
    const bool is_all = &row == &report.classes.back();
    const auto of_all = [&](double value, const Interval& interval) {
      return is_all ? with_interval(value, interval) : figure(value);
    };
    rows.push_back(
        {escaped(row.class_name), std::to_string(row.views + row.views_without_label),
         figure(row.label_prior, 2), of_all(row.average_precision, report.average_precision_interval),
         of_all(row.average_precision_border_ignored, report.average_precision_border_ignored_interval),
         of_all(row.roc_area, report.roc_area_interval),
         of_all(row.calibration_error, report.calibration_error_interval),
         with_interval(row.top1, row.top1_interval), figure(row.top1_chance, 2)});
  }
  return table({"class", "views", "prior", "AP", "AP, border ignored", "ROC AUC", "ECE", "top-1", "chance"},
               rows);
}

std::string section(const std::string& heading, const std::string& body, const std::string& note) {
  return "<section>\n<h2>" + escaped(heading) + "</h2>\n" + body + "<p class=\"note\">" + escaped(note) +
         "</p>\n</section>\n";
}

std::string precision_recall_section(const EvaluationReport& report) {
  SvgChart chart("Precision against recall", "recall", "precision");
  chart.unit_ticks();
  const double prior = report.classes.back().label_prior;
  chart.line({{0, prior}, {1, prior}}, "reference");
  SvgChart::Points points;
  for (const PrecisionRecallPoint& point : report.precision_recall) {
    points.emplace_back(point.recall, point.precision);
  }
  chart.line(points, "curve");
  return section("Precision and recall", chart.finish(),
                 "Over all patches. Dashed: the prior, what guessing would reach.");
}

/// Counts that fit over a bin.
std::string short_count(int count) {
  return count < 10000 ? std::to_string(count) : decimal_text(count / 1000.0, 0) + "k";
}

std::string calibration_section(const EvaluationReport& report) {
  SvgChart chart("Reliability diagram", "probability that the model answers", "share of positive patches");
  chart.unit_ticks();
  for (const CalibrationBin& bin : report.calibration) {
    if (bin.patches > 0) chart.bar(bin.low, bin.high, 0, bin.positive_share, "hit");
  }
  chart.line({{0, 0}, {1, 1}}, "reference");
  for (const CalibrationBin& bin : report.calibration) {
    if (bin.patches > 0) chart.dot(bin.mean_probability, bin.positive_share, "point");
    chart.text((bin.low + bin.high) / 2, 0.95, short_count(bin.patches));
  }
  return section("Calibration", chart.finish(),
                 "Bars and dots (at the mean probability of the bin) lie on the diagonal where probabilities "
                 "can be taken at their word. Above: patches in each bin.");
}

std::string learning_section(const EvaluationReport& report) {
  if (report.learning_curve.empty()) return "";
  const int most = std::max(1, report.learning_curve.back().images);
  SvgChart chart("Learning curve", "images trained on", "AP", 1.05 * most);
  SvgChart::Points points;
  std::string last_tick;
  for (const LearningPoint& point : report.learning_curve) {
    points.emplace_back(point.images, point.average_precision);
    const std::string tick = std::to_string(point.images);
    if (tick != last_tick) chart.tick(point.images, tick);
    last_tick = tick;
    const Interval& interval = point.average_precision_interval;
    if (!std::isnan(interval.low)) chart.band(point.images, interval.low, interval.high);
  }
  chart.line(points, "curve");
  for (const auto& [x, y] : points) chart.dot(x, y, "point");
  return section("Learning curve", chart.finish(),
                 "AP on the images of each fold, held out, against how many of the others were trained on. "
                 "Where it still rises at the right, more images help.");
}

/// "2–5 %"
std::string share_text(const LabelShareRow& row) {
  return row.high == 0 ? "hidden" : decimal_text(100 * row.low, 0) + "–" + percent(row.high);
}

std::string label_share_section(const EvaluationReport& report) {
  const auto count = static_cast<double>(report.label_shares.size() - 1);
  SvgChart chart("Top-1 by the visible share of the label", "visible label, share of the object",
                 "share of views", count);
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < report.label_shares.size(); ++i) {
    const LabelShareRow& row = report.label_shares[i];
    const bool hidden = i == 0;
    rows.push_back({share_text(row), std::to_string(row.views), hidden ? "–" : std::to_string(row.hits),
                    hidden ? "–" : std::to_string(row.views - row.hits),
                    figure(row.mean_best_probability, 2)});
    if (hidden) continue;
    const double x = static_cast<double>(i) - 1;
    chart.tick(x + 0.5, share_text(row));
    if (row.views == 0) continue;
    const double hit_share = static_cast<double>(row.hits) / row.views;
    chart.bar(x + 0.15, x + 0.85, 0, hit_share, "hit");
    chart.bar(x + 0.15, x + 0.85, hit_share, 1, "miss");
    chart.text(x + 0.5, 0.03, std::to_string(row.hits) + " of " + std::to_string(row.views));
  }
  return section(
      "Hits by visible label",
      chart.finish() + table({"visible label", "views", "hits", "misses", "mean best P"}, rows),
      "Blue: views whose most probable patch lies on the label; orange: misses. Hidden: no patch of "
      "the view is labelled, there is nothing to hit, and the best answer should be small.");
}

std::string worst_section(const EvaluationReport& report) {
  if (report.worst.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const ViewResult& view : report.worst) {
    rows.push_back({escaped(view.source), escaped(view.class_name), figure(view.average_precision),
                    view.hit ? "hit" : "miss", figure(view.best_probability, 2),
                    percent(view.visible_label_share)});
  }
  return "<h2>Worst views</h2>\n" + table({"view", "class", "AP", "top-1", "best P", "visible label"}, rows);
}

}  // namespace

std::string report_to_html(const ReportHead& head, const EvaluationReport& report) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width\"/>\n<title>" +
         escaped(head.title) + "</title>\n<style>\n" + page_style + SvgChart::style() +
         "</style>\n</head>\n<body>\n<h1>" + escaped(head.title) + "</h1>\n" + facts_table(head) +
         figures_table(report) +
         "<p class=\"note\">AP: average precision over patches; border ignored: without patches of which "
         "less "
         "than half is labelled. ECE: expected calibration error. top-1: share of views whose most probable "
         "patch lies on the label; chance: a random patch. In brackets: intervals of 95 %, by resampling " +
         std::to_string(report.images) +
         " images; Wilson's for top-1.</p>\n"
         "<div class=\"figures\">\n" +
         precision_recall_section(report) + calibration_section(report) + learning_section(report) +
         label_share_section(report) + "</div>\n" + worst_section(report) + "<p class=\"note\">graspctx " +
         version + "</p>\n</body>\n</html>\n";
}

}  // namespace graspctx
