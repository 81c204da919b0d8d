// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <gtest/gtest.h>

#include "io/ct.hpp"
#include "io/plus_config.hpp"
#include "io/sequence.hpp"
#include "io/surface_file.hpp"
#include "io/transform_tree.hpp"
#include "tests/io/dicom_file.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

/// Counter-based random numbers (splitmix64), so that the mutations are equal on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(next() % n); }

 private:
  std::uint64_t state_;
};

/// Changes the bytes in one to four ways: a changed byte, a flipped bit, a piece cut out, doubled
/// or replaced by an extreme number, or the end cut off.
std::string mutated(std::string bytes, Random& random) {
  const std::size_t times = 1 + random.below(4);
  for (std::size_t i = 0; i < times && !bytes.empty(); ++i) {
    const std::size_t at = random.below(bytes.size());
    const std::size_t size = std::min(1 + random.below(20), bytes.size() - at);
    switch (random.below(6)) {
      case 0:
        bytes[at] = static_cast<char>(random.next());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
        break;
      case 2:
        bytes.erase(at, size);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, size));
        break;
      case 4: {
        constexpr std::array kNumbers = {
            "-1", "0", "4294967297", "9223372036854775807", "nan", "1e999", "%s", "=", ":", "\n"};
        bytes.replace(at, size, kNumbers[random.below(kNumbers.size())]);
        break;
      }
      default:
        bytes.resize(at);
    }
  }
  return bytes;
}

/// Reads everything that a damaged recording offers. The results do not matter.
void read_sequence(const std::filesystem::path& path) {
  auto reader = SequenceReader::open(path);
  if (!reader) {
    EXPECT_EQ(reader.error().message.find('\n'), std::string::npos) << reader.error().message;
    return;
  }
  constexpr std::int64_t kFrames = 5;
  for (std::int64_t i = 0; i < std::min(kFrames, reader->header().frame_count); ++i) {
    const auto frame = reader->read(i);
    if (!frame) continue;
    EXPECT_EQ(frame->pixels.size(), reader->header().frame_bytes());
    for (const std::string& name : transform_names(*frame)) (void)transform(*frame, name);
    (void)brightness_image(reader->header(), *frame);
  }
}

void read_volume(const std::filesystem::path& path) {
  CollectingDiagnostics diagnostics;
  CtOptions options;
  options.accept_unknown_orientation = true;
  const auto volume = read_ct(path, diagnostics, options);
  if (volume) {
    EXPECT_EQ(volume->hu().size(), volume->grid().voxel_count());
  }
}

void read_config(const std::filesystem::path& path) {
  const auto config = read_plus_config(path);
  if (!config) return;
  const auto tree = TransformTree::create({"ProbeToTracker"}, config->transforms);
  if (tree) (void)tree->find("Image", "Tracker");
  for (const auto& t : config->transforms) (void)calibration_from_matrix(t.to_from_from, 10, 10);
}

using Reader = void (*)(const std::filesystem::path&);

/// A parser may accept or reject a file, but it must not crash, throw, or allocate without limit.
void fuzz(const std::string& name, const std::string& golden, int times, Reader reader,
          const std::vector<std::pair<std::string, std::string>>& beside = {}) {
  // The test writes thousands of small files. Files in memory are faster than files on a disk.
  if (std::filesystem::is_directory("/dev/shm")) ::setenv("TMPDIR", "/dev/shm", 0);
  const test::TemporaryFolder folder;
  for (const auto& [other, bytes] : beside) test::put(folder / other, bytes);
  constexpr std::uint64_t kSeed = 20260101;
  Random random(kSeed);
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < times; ++i) {
    test::put(folder / name, mutated(golden, random));
    EXPECT_NO_THROW(reader(folder / name)) << name << " mutation " << i;
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << name;
}

const std::string kPixels(3 * 2 * 2, 'p');
constexpr int kTimes = 1000;

std::string meta(const std::string& extra) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" +
         extra +
         "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\n"
         "DimSize = 3 2 2\nKinds = domain domain list\nElementType = MET_UCHAR\n"
         "UltrasoundImageOrientation = MF\n"
         "Seq_Frame0000_ProbeToTrackerTransform = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"
         "Seq_Frame0000_ProbeToTrackerTransformStatus = OK\nSeq_Frame0000_Timestamp = 1.5\n"
         "Seq_Frame0001_Timestamp = 2.5\nElementDataFile = LOCAL\n";
}

std::string nrrd(const std::string& encoding) {
  return "NRRD0004\ndimension: 3\nencoding: " + encoding +
         "\nendian: little\nkinds: domain domain list\nsizes: 3 2 2\ntype: uint8\nspace: LPS\n"
         "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n"
         "ultrasound image orientation:=MF\nSeq_Frame0000_Status:=OK\n\n";
}

TEST(FuzzTest, DamagedMetaImagesDoNotCrash) {
  fuzz("a.mha", meta("") + kPixels, kTimes, read_sequence);
  fuzz("z.mha", meta("CompressedData = True\n") + test::deflated(kPixels), kTimes, read_sequence);
  fuzz("v.mha", meta("") + kPixels, kTimes, read_volume);
}

TEST(FuzzTest, DamagedNrrdFilesDoNotCrash) {
  constexpr int kGzip = 31;
  fuzz("a.nrrd", nrrd("raw") + kPixels, kTimes, read_sequence);
  fuzz("z.nrrd", nrrd("gzip") + test::deflated(kPixels, kGzip), kTimes, read_sequence);
  fuzz("v.nrrd", nrrd("raw") + kPixels, kTimes, read_volume);
}

TEST(FuzzTest, DamagedNiftiFilesDoNotCrash) {
  std::string h(352, '\0');
  const auto set = [&](std::size_t at, const std::string& bytes) {
    h.replace(at, bytes.size(), bytes);
  };
  set(0, test::le<std::int32_t>(348));
  set(40, test::bytes_of(std::vector<std::int16_t>{3, 3, 2, 2, 1, 1, 1, 1}));
  set(70, test::le<std::int16_t>(2));
  set(76, test::bytes_of(std::vector<float>{1, 1, 1, 1}));
  set(108, test::bytes_of(std::vector<float>{352}));
  set(254, test::le<std::int16_t>(1));
  set(280, test::bytes_of(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}));
  set(344, std::string("n+1\0", 4));
  fuzz("a.nii", h + kPixels, kTimes, read_volume);
  constexpr int kGzip = 31;
  fuzz("a.nii.gz", test::deflated(h + kPixels, kGzip), kTimes, read_volume);
}

void read_folder(const std::filesystem::path& path) { read_volume(path.parent_path()); }

TEST(FuzzTest, DamagedDicomFilesDoNotCrash) {
  const auto slice = [](const char* position) {
    return test::ct_slice(position, [](int i, int j) { return 10 * i + j; });
  };
  constexpr int kDicomTimes = 800;
  fuzz("a.dcm", slice("1\\2\\3").bytes(), kDicomTimes, read_volume);
  // The file lies beside two valid slices, so that the reader also decodes its pixels. One of the
  // cases is run-length coded.
  const std::vector<std::pair<std::string, std::string>> sound = {
      {"b.dcm", slice("1\\2\\5").bytes()}, {"c.dcm", slice("1\\2\\7").bytes()}};
  fuzz("a.dcm", slice("1\\2\\3").bytes(), kDicomTimes, read_folder, sound);
  fuzz("a.dcm", slice("1\\2\\3").implicit().bytes(), kDicomTimes, read_folder, sound);
  auto coded = slice("1\\2\\3");
  coded.encapsulated({test::run_length_code(std::vector<std::int16_t>(20, 1000))},
                     "1.2.840.10008.1.2.5");
  fuzz("a.dcm", coded.bytes(), kDicomTimes, read_folder, sound);
}

void read_mesh(const std::filesystem::path& path) {
  const auto mesh = read_surface(path);
  if (!mesh) return;
  for (const auto& triangle : mesh->triangles) {
    for (const int corner : triangle) {
      EXPECT_TRUE(corner >= 0 && static_cast<std::size_t>(corner) < mesh->points_mm.size());
    }
  }
}

TEST(FuzzTest, DamagedSurfaceFilesDoNotCrash) {
  const std::string vtk = "POINTS 4 float\n0 0 0 1 0 0 1 1 0\n0 1 0\n";
  fuzz("a.vtk",
       "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n" + vtk +
           "POLYGONS 2 8\n3 0 1 2\n3 0 2 3\nTRIANGLE_STRIPS 1 4\n3 0 1 2\nPOINT_DATA 4\n",
       kTimes, read_mesh);
  fuzz("b.vtk",
       "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\n" + vtk +
           "METADATA\nINFORMATION 0\n\nPOLYGONS 3 6\nOFFSETS vtktypeint64\n0 3 6\n"
           "CONNECTIVITY vtktypeint64\n0 1 2 0 2 3\n",
       kTimes, read_mesh);
  const std::string points = test::bytes_of(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0});
  fuzz("c.vtk",
       "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 3 float\n" +
           test::swapped_bytes_of(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0}) +
           "\nPOLYGONS 1 4\n" + test::swapped_bytes_of(std::vector<std::int32_t>{3, 0, 1, 2}),
       kTimes, read_mesh);
  const auto ply = [](const std::string& format) {
    return "ply\nformat " + format +
           " 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  };
  fuzz("a.ply", ply("ascii") + "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n", kTimes, read_mesh);
  fuzz("b.ply",
       ply("binary_little_endian") + points + "\3" +
           test::bytes_of(std::vector<std::int32_t>{0, 1, 2}),
       kTimes, read_mesh);
  fuzz("a.stl",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n"
       "endloop\nendfacet\nendsolid a\n",
       kTimes, read_mesh);
  fuzz("b.stl",
       std::string(80, ' ') + test::le<std::uint32_t>(1) + std::string(12, '\0') + points +
           std::string(2, '\0'),
       kTimes, read_mesh);
}

TEST(FuzzTest, DamagedConfigurationsDoNotCrash) {
  fuzz("c.xml",
       "<PlusConfiguration version=\"2.4\"><DataCollection><Device Id=\"V\" "
       "LocalTimeOffsetSec=\"0.5\"><DataSources><DataSource Id=\"D\"/></DataSources></Device>"
       "</DataCollection><CoordinateDefinitions><Transform From=\"Image\" To=\"Probe\" Matrix=\""
       "0.1 0 0 1 0 0.1 0 2 0 0 0.1 3 0 0 0 1\"/></CoordinateDefinitions><ScanConversion "
       "TransducerGeometry=\"LINEAR\" OutputImageSpacingMmPerPixel=\"0.1 0.1\"/>"
       "</PlusConfiguration>",
       kTimes, read_config);
}

}  // namespace
}  // namespace nav::io
