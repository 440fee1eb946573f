#include "sim/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "sim/data_directory.h"
#include "sim/model_file.h"

namespace saccade {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* tetrahedron =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n"
    "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// Files in a folder of their own.
class OwnFile : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return (folder_ / name).string();
  }
  /// The only problem that reading a mesh gives.
  std::string mesh_problem(const std::string& name, const std::string& content, double scale = 1.0) {
    return problem([&] { static_cast<void>(read_mesh_file(write(name, content), scale)); });
  }
  /// The only problem of an MJCF file.
  std::string model_problem(const std::string& content, ModelUse use = ModelUse::object) {
    return problem([&] { static_cast<void>(read_model_file(write("model.xml", content), "test", use)); });
  }

  fs::path folder_ =
      fs::path(testing::TempDir()) /
      (std::string("mesh_file_") + testing::UnitTest::GetInstance()->current_test_info()->name());

 private:
  static std::string problem(const std::function<void()>& read) {
    try {
      read();
    } catch (const InputError& error) {
      EXPECT_EQ(error.problems().size(), 1U) << error.what();
      const std::string text = error.problems().front().text();
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      return text;
    }
    ADD_FAILURE() << "was read without a complaint";
    return {};
  }
};

using MeshFile = OwnFile;
using ModelFile = OwnFile;

TEST_F(MeshFile, ReadsFacesOfAnObjWithPolygonsAndTextureCoordinates) {
  const TriangleMesh mesh = read_mesh_file(
      write("cube.obj",
            "# a cube\nv 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nv 0 0 100\nv 100 0 100\nv 100 100 100\nv "
            "0 100 100\n"
            "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\ng sides\n"
            "f 4/1/1 3/2/1 2/3/1 1/3/1\nf 5 6 7 8\nf 1 2 6 5\nf -6 -5 -1 -2\nf 2 3 7 6\nf 4 1 5 8\n"),
      0.001);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_EQ(mesh.points_m[6], Eigen::Vector3d(0.1, 0.1, 0.1));
  ASSERT_TRUE(mesh.has_texels());
  EXPECT_EQ(mesh.texels[2], Eigen::Vector2d(1.0, 0.0)) << "v of an OBJ points up, of a texture down";
  EXPECT_EQ(mesh.triangles[0][1].texel, 1);
  EXPECT_EQ(mesh.triangles[2][0].texel, -1);
}

TEST_F(MeshFile, ReadsTheSameSurfaceFromATextAndABinaryStl) {
  const TriangleMesh obj = read_mesh_file(write("a.obj", tetrahedron), 1.0);
  std::string text = "solid a\n";
  std::string binary(80, ' ');
  const auto count = static_cast<std::uint32_t>(obj.triangles.size());
  binary.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const auto& triangle : obj.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    std::array<float, 12> values{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = obj.points_m[static_cast<std::size_t>(triangle[k].point)];
      text += "vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) +
              "\n";
      for (std::size_t i = 0; i < 3; ++i) values[3 + 3 * k + i] = static_cast<float>(p[static_cast<int>(i)]);
    }
    text += "endloop\nendfacet\n";
    binary.append(reinterpret_cast<const char*>(values.data()), sizeof values);
    binary.append(2, '\0');
  }
  for (const TriangleMesh& stl :
       {read_mesh_file(write("a.stl", text), 1.0), read_mesh_file(write("b.STL", binary), 1.0)}) {
    ASSERT_EQ(stl.triangles.size(), obj.triangles.size());
    for (std::size_t i = 0; i < stl.points_m.size(); ++i) {
      const auto& corner = obj.triangles[i / 3][i % 3];
      EXPECT_LT((stl.points_m[i] - obj.points_m[static_cast<std::size_t>(corner.point)]).norm(), 1e-6);
    }
  }
}

TEST_F(MeshFile, SaysInOneLineWhatIsWrong) {
  const std::string whole = tetrahedron;
  const std::string three_faces = whole.substr(0, whole.rfind("f 3"));
  EXPECT_THAT(mesh_problem("open.obj", three_faces),
              HasSubstr("open.obj: found 3 edges of one triangle, the first from (0, 0, 0) to (0, 0.1, 0), "
                        "expected a closed surface"));
  EXPECT_THAT(mesh_problem("fin.obj", whole + "v 0 0 -0.1\nf 1 2 5\nf 2 1 5\n"),
              HasSubstr("fin.obj: found 1 edges of three triangles or more"));
  EXPECT_THAT(mesh_problem("turned.obj", three_faces + "f 1 3 4\n"),
              HasSubstr("edges whose two triangles face opposite sides"));
  EXPECT_THAT(mesh_problem("inside_out.obj",
                           "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n"),
              HasSubstr("inside out"));
  EXPECT_THAT(mesh_problem("far.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n"),
              HasSubstr("far.obj:3: found \"3\", expected the number of a point, 1 to 2"));
  EXPECT_THAT(mesh_problem("nan.obj", "v 0 0 nan\n"),
              HasSubstr("nan.obj:1: found \"nan\", expected a finite number"));
  EXPECT_THAT(mesh_problem("short.obj", "v 0 0\n"), HasSubstr("short.obj:1: found 2 numbers"));
  EXPECT_THAT(mesh_problem("mm.obj", whole, 1000.0),
              HasSubstr("mm.obj: found a mesh of 100 m, expected an extent in metres in [0.001, 5]"));
  EXPECT_THAT(mesh_problem("cut.stl", "binary" + std::string(90, 'x')),
              HasSubstr("96 bytes that are no STL"));
  EXPECT_THAT(mesh_problem("mug.ply", "ply\n"),
              HasSubstr("found the extension \".ply\", expected .obj or .stl"));
  EXPECT_THAT(mesh_problem("empty.obj", ""), HasSubstr("empty.obj: expected a mesh"));
}

TEST_F(MeshFile, RefusesAHugeMesh) {
  std::string text;
  const int side = 170;  // 2 * 170 * 170 triangles
  for (int i = 0; i < (side + 1) * (side + 1); ++i) text += "v 0 0 0\n";
  for (int i = 0; i < side * side; ++i) text += "f 1 2 3 4\n";
  EXPECT_THAT(mesh_problem("huge.obj", text),
              HasSubstr("huge.obj: found 57800 triangles, expected at most 50000"));
}

TEST_F(MeshFile, NamesAFileThatIsMissing) {
  try {
    static_cast<void>(read_mesh_file("/nowhere/mug.obj", 1.0));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/mug.obj: expected a readable mesh file"));
  }
}

TEST(SphereRadius, IsThatOfARoundMeshAndNoOther) {
  TriangleMesh mesh;
  const auto point = [&](double polar, double around) {
    mesh.points_m.emplace_back(0.05 * std::sin(polar) * std::cos(around),
                               0.05 * std::sin(polar) * std::sin(around), 0.05 * std::cos(polar));
    return TriangleMesh::Corner{static_cast<int>(mesh.points_m.size()) - 1, -1};
  };
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 24; ++j) {
      const double step = 3.14159265 / 12;
      const auto a = point(i * step, j * step);
      const auto b = point((i + 1) * step, j * step);
      const auto c = point((i + 1) * step, (j + 1) * step);
      mesh.triangles.push_back({a, b, c});
    }
  }
  EXPECT_NEAR(sphere_radius_m(mesh), 0.05, 1e-9);
  for (Eigen::Vector3d& p : mesh.points_m) p.z() *= 1.1;
  EXPECT_EQ(sphere_radius_m(mesh), 0.0);
}

TEST_F(ModelFile, KeepsEveryGeomWhereItIs) {
  const ModelParts parts =
      read_model_file(write("ok.xml",
                            "<mujoco><default><geom rgba='1 0 0 1'/></default><worldbody><body pos='1 0 0' "
                            "euler='0 0 90'><freejoint/>"
                            "<geom type='box' size='.1 .2 .3' pos='0.5 0 0'/><geom type='sphere' size='.1' "
                            "group='4'/></body></worldbody></mujoco>"),
                      "test", ModelUse::object);
  EXPECT_THAT(
      parts.geoms,
      HasSubstr("type=\"box\" pos=\"1 0.5 0\" quat=\"0.7071068 0 0 0.7071068\" size=\"0.1 0.2 0.3\""));
  EXPECT_THAT(parts.geoms, HasSubstr("rgba=\"1 0 0 1\""));
  EXPECT_THAT(parts.geoms, testing::Not(HasSubstr("sphere"))) << "group 4 is not shown";
  EXPECT_EQ(parts.sphere_radius_m, 0.0);
}

TEST_F(ModelFile, SaysInOneLineWhatIsWrong) {
  const auto body = [](const std::string& inside) {
    return "<mujoco><worldbody><body>" + inside + "</body></worldbody></mujoco>";
  };
  const std::string ball = "<geom size='.1'/>";
  EXPECT_THAT(model_problem(body("<joint name='lid' type='hinge'/>" + ball)),
              HasSubstr("model.xml: found the hinge joint \"lid\", expected a rigid object without joints, "
                        "or with one free joint"));
  EXPECT_THAT(model_problem(body("<joint type='slide'/>" + ball), ModelUse::lab),
              HasSubstr("found the slide joint number 0, expected a lab without joints"));
  EXPECT_THAT(model_problem(body("<freejoint/>" + ball), ModelUse::lab), HasSubstr("the free joint"));
  EXPECT_THAT(model_problem("<mujoco><worldbody/></mujoco>"), HasSubstr("found no geoms of groups 0 to 2"));
  EXPECT_THAT(model_problem(
                  "<mujoco><worldbody><geom type='plane' size='1 1 1' name='ground'/></worldbody></mujoco>"),
              HasSubstr("found the plane \"ground\", expected geoms of finite size"));
  EXPECT_THAT(model_problem(body("<geom size='50'/>")), HasSubstr("found a geom 50 m from the origin"));
  EXPECT_THAT(model_problem("<mujoco><worldbody"), HasSubstr("expected a valid MJCF model"));
  EXPECT_THAT(model_problem(body("<goem size='1'/>")), HasSubstr("goem"));
  EXPECT_THAT(model_problem("<mujoco><asset><mesh file='gone.obj'/></asset><worldbody><geom type='mesh' "
                            "mesh='gone'/></worldbody></mujoco>"),
              HasSubstr("gone.obj"));
}

TEST_F(ModelFile, ScalesTheTextureOfAPrimitiveAndNotOfAMeshWithTextureCoordinates) {
  const ModelParts parts = read_model_file(
      write("ok.xml",
            "<mujoco><asset><texture name='t' type='2d' builtin='flat' width='8' height='8' rgb1='1 0 0'/>"
            "<material name='m' texture='t' texrepeat='3 2'/><mesh name='tetrahedron' "
            "vertex='0 0 0 .1 0 0 0 .1 0 0 0 .1' texcoord='0 0 1 0 0 1 1 1' "
            "face='0 2 1 0 1 3 1 2 3 2 0 3'/></asset><worldbody><geom size='.1' material='m'/>"
            "<geom type='mesh' mesh='tetrahedron' material='m'/></worldbody></mujoco>"),
      "test", ModelUse::object);
  EXPECT_THAT(parts.assets, HasSubstr("<material name=\"test_material_0\" texture=\"test_texture_0\" "
                                      "texrepeat=\"3 2\" texuniform=\"false\""));
  EXPECT_THAT(parts.assets,
              HasSubstr("<material name=\"test_mesh_material_0\" texture=\"test_texture_0\" emission"));
  EXPECT_EQ(parts.textures.size(), 1U);
}

TEST_F(ModelFile, RefusesATextureInGreyAndALightThatIsNotDrawn) {
  if (mjVERSION_HEADER < 333) GTEST_SKIP() << "NOT TESTED, MuJoCo " << mj_versionString() << " has neither";
  EXPECT_THAT(model_problem("<mujoco><worldbody><light name='bulb' type='point'/><geom "
                            "size='.1'/></worldbody></mujoco>",
                            ModelUse::lab),
              HasSubstr("found the light \"bulb\" that MuJoCo's renderer does not draw, expected lights of"));
  const std::string png = (data_directory() / "scenarios/assets/football.png").string();
  const auto with_channels = [&](const std::string& channels) {
    return "<mujoco><asset><texture name='t' type='2d' file='" + png + "' nchannel='" + channels +
           "'/><material name='m' texture='t'/></asset><worldbody><geom size='.1' "
           "material='m'/></worldbody></mujoco>";
  };
  EXPECT_THAT(model_problem(with_channels("1")),
              HasSubstr("found the texture \"t\" in grey, expected a texture in colour"));
  const auto texels = [&](const std::string& channels) {
    return read_model_file(write("model.xml", with_channels(channels)), "test", ModelUse::object)
        .textures.at(0)
        .rgb;
  };
  EXPECT_EQ(texels("4"), texels("3")) << "without the opacity";
}

TEST_F(ModelFile, ChecksTheMeshesOfAnObject) {
  const std::string whole = tetrahedron;
  write("open.obj", whole.substr(0, whole.rfind("f 3")) + "v 0.2 0 0\nv 0.2 0.1 0\nv 0.2 0 0.1\nf 5 6 7\n");
  EXPECT_THAT(model_problem("<mujoco><asset><mesh name='cup' file='open.obj'/></asset><worldbody><geom "
                            "type='mesh' mesh='cup'/></worldbody></mujoco>"),
              HasSubstr("mesh \"cup\": found 6 edges of one triangle"));
}

TEST_F(ModelFile, RefusesAnImageThatIsNoPanorama) {
  const std::string path = write("image.png", "no image");
  try {
    static_cast<void>(read_png(path, "test"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("expected a PNG image"));
  }
}

}  // namespace
}  // namespace saccade
