#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/detector_registry.h"
#include "core/detectors/built_in_detectors.h"
#include "core/registry_configs.h"
#include "core/registry_rows.h"
#include "core/type_erased_config.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

struct Small {
  double size = 1.0;
};
void describe(FieldVisitor& v, Small& config) { v.real("size", config.size, {0.0, 2.0}, ""); }

struct Other {
  std::int64_t count = 3;
};
void describe(FieldVisitor& v, Other& config) { v.integer("count", config.count, {0, 9}, ""); }

TEST(TypeErasedConfig, CopiesHoldConfigsOfTheirOwn) {
  TypeErasedConfig config{Small{}};
  TypeErasedConfig copy = config;
  copy.get<Small>().size = 1.5;
  EXPECT_EQ(config.get<Small>().size, 1.0);
  config = copy;
  EXPECT_EQ(config.get<Small>().size, 1.5);
}

TEST(TypeErasedConfig, KnowsItsType) {
  TypeErasedConfig config{Small{}};
  EXPECT_NE(config.get_if<Small>(), nullptr);
  EXPECT_EQ(config.get_if<Other>(), nullptr);
  EXPECT_DEATH(static_cast<void>(config.get<Other>()), "");
}

TEST(TypeErasedConfig, IsDescribedAsWhatItHolds) {
  TypeErasedConfig config{Small{3.0}};
  EXPECT_THAT([&] { check_config("it", config); }, ThrowsMessage<InputError>(HasSubstr("it.size: found 3")));
  config.get<Small>().size = 2.0;
  EXPECT_NO_THROW(check_config("it", config));
}

struct Row {
  std::string name, description;
  TypeErasedConfig config;
  std::function<double(const TypeErasedConfig&)> make;
};

Row small_row(std::string name, double size) {
  return row_of<Row>(std::move(name), "", Small{size}, [](const Small& config) { return config.size; });
}

TEST(RegistryRows, KeepTheirOrderAndRefuseNamesThatAreTakenOrNone) {
  RegistryRows<Row> rows;
  rows.add(small_row("b", 1.0));
  rows.add(small_row("a", 2.0));
  EXPECT_THAT(rows.names(), ElementsAre("b", "a"));
  EXPECT_EQ(rows.find("c"), nullptr);
  EXPECT_EQ(rows.find("a")->make(rows.find("a")->config), 2.0);
  EXPECT_THAT([&] { rows.add(small_row("a", 2.0)); },
              ThrowsMessage<InputError>(HasSubstr("found a, expected a name that no row has yet")));
  EXPECT_THROW(rows.add(small_row("a b", 2.0)), InputError);
  EXPECT_EQ(rows.size(), 2U);
}

TEST(RegistryRows, CopiesDoNotGrowWithTheOriginal) {
  RegistryRows<Row> rows;
  rows.add(small_row("a", 1.0));
  const RegistryRows<Row> copy = rows;
  const Row* const row = copy.find("a");
  rows.add(small_row("b", 1.0));
  EXPECT_THAT(copy.names(), ElementsAre("a"));
  EXPECT_EQ(copy.find("a"), row);
}

TEST(RegistryConfigs, HoldAConfigForEachRow) {
  RowRegistry<Row> registry;
  registry.add(small_row("one", 1.0));
  registry.add(small_row("two", 2.0));
  registry.add(row_of<Row>("other", "", Other{}, [](const Other&) { return 0.0; }));
  RegistryConfigs<Row> configs(registry.rows());
  EXPECT_EQ(configs.of("two").get<Small>().size, 2.0);
  EXPECT_EQ(configs.get<Other>().count, 3);
  configs.get<Small>().size = 0.5;
  EXPECT_EQ(configs.of("one").get<Small>().size, 0.5);
  EXPECT_EQ(registry.rows().find("one")->config.get<Small>().size, 1.0);
  EXPECT_EQ(configs.get_if<NoKeys>(), nullptr);
  EXPECT_DEATH(static_cast<void>(configs.of("three")), "");
}

TEST(DetectorRegistry, MakesConfigsByName) {
  const DetectorRegistry registry = built_in_detectors();
  EXPECT_TRUE(registry.has("best"));
  EXPECT_FALSE(registry.has("worst"));
  EXPECT_EQ(registry.config("best").preset(), "best");
  EXPECT_THROW(static_cast<void>(registry.config("worst")), InputError);
  DetectorRegistry more = registry;
  EXPECT_THROW(more.add(*registry.rows().find("best")), InputError) << "taken";
  DetectorRow none = *registry.rows().find("best");
  none.name = "none";
  EXPECT_THROW(more.add(none), InputError) << "stands for no detector";
}

TEST(DetectorConfig, ScalesItsThresholdWithinTheRange) {
  DetectorConfig config = built_in_detectors().config("best");  // a probability
  EXPECT_TRUE(config.scale_threshold(1.5));
  EXPECT_DOUBLE_EQ(make_detector(config, icub_left_2016)->threshold(), 0.75);
  EXPECT_FALSE(config.scale_threshold(1.5)) << "above 1";
  EXPECT_DOUBLE_EQ(make_detector(config, icub_left_2016)->threshold(), 0.75);
}

}  // namespace
}  // namespace saccade
