#include "evaluation/report/svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(PageSvg, WorksWithAndWithoutADescriptionOfGnuplot) {
  const std::string with = "<?xml?>\n<svg x='1'>\n<desc>Produced by GNUPLOT</desc>\n<g/></svg>\n\n";
  EXPECT_EQ(page_svg(with, "a"), "<svg x='1'>\n\n<g/></svg>");
  const std::string without = "<?xml?>\n<svg x='1'>\n<g/></svg>\n\n";
  EXPECT_EQ(page_svg(without, "a"), "<svg x='1'>\n<g/></svg>");
}

TEST(PageSvg, PrefixesIdsAndTheirReferencesInTagsAlone) {
  const std::string svg = page_svg(
      "<svg><g id='gpPt6' k=\"1\"/><use xlink:href='#gpPt6'/><text>a id='b' '#gp</text></svg>", "fig");
  EXPECT_THAT(svg, HasSubstr("<g id='fig_gpPt6'"));
  EXPECT_THAT(svg, HasSubstr("'#fig_gpPt6'"));
  EXPECT_THAT(svg, HasSubstr("<text>a id='b' '#gp</text>"));
}

TEST(WithoutNamespaces, RemovesDeclarationsButLeavesTextThatLooksLikeOne) {
  const std::string svg = without_namespaces(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://w3\"><text>xmlns without a "
      "value</text></svg>");
  EXPECT_THAT(svg, Not(HasSubstr("http")));
  EXPECT_THAT(svg, HasSubstr("<text>xmlns without a value</text>"));
}

}  // namespace
}  // namespace saccade
