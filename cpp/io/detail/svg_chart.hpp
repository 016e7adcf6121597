#pragma once
#include <string>
#include <utility>
#include <vector>

namespace graspctx::detail {

/// Text that is safe in HTML and SVG.
std::string escaped(const std::string& text);

/// A chart as inline SVG with y from 0 to 1, drawn in the order of the calls.
class SvgChart {
 public:
  using Points = std::vector<std::pair<double, double>>;

  /// x from 0 to x_max; title: read out by screen readers.
  SvgChart(const std::string& title, const std::string& x_label, const std::string& y_label,
           double x_max = 1);
  void tick(double x, const std::string& text);
  void unit_ticks();  // 0, 0.2, … 1
  void line(const Points& points, const char* css_class);
  void band(double x, double low, double high);  // an interval
  void dot(double x, double y, const char* css_class);
  void bar(double x_low, double x_high, double y_low, double y_high, const char* css_class);
  void text(double x, double y, const std::string& text);
  std::string finish();

  /// The rules for its classes, for the head of the page.
  static const char* style();

 private:
  std::string x_text(double x) const;
  std::string y_text(double y) const;

  double x_max_;
  std::string svg_;
};

}  // namespace graspctx::detail
