// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/dicom_series.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <vtkCommand.h>
#include <vtkDICOMDictionary.h>
#include <vtkDICOMItem.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMSequence.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include "io/detail/dicom_codestream.hpp"
#include "io/detail/dicom_structure.hpp"
#include "io/detail/input_file.hpp"
#include "io/detail/text.hpp"
#include "io/detail/vtk_errors.hpp"

namespace nav::io::detail {

namespace {

/// Finite numbers of an attribute of one frame; empty unless there are exactly \p count.
std::vector<double> numbers(vtkDICOMMetaData& meta, int frame, DC::EnumType tag,
                            std::size_t count) {
  const vtkDICOMValue& value = meta.Get(0, frame, vtkDICOMTag(tag));
  if (!value.IsValid() || value.GetNumberOfValues() != count) return {};
  std::vector<double> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    // The text is parsed here, because the library's own parser reads "abc" as 0.
    const auto number = parse_double(value.GetString(i));
    if (!number || !std::isfinite(*number)) return {};
    out[i] = *number;
  }
  return out;
}

/// True when a frame has any value in an attribute.
bool has(vtkDICOMMetaData& meta, int frame, DC::EnumType tag) {
  const vtkDICOMValue& value = meta.Get(0, frame, vtkDICOMTag(tag));
  return value.IsValid() && !trim(value.AsString()).empty();
}

std::string text(vtkDICOMMetaData& meta, DC::EnumType tag) {
  const vtkDICOMValue& value = meta.Get(0, 0, vtkDICOMTag(tag));
  return value.IsValid() ? std::string(trim(value.AsString())) : std::string();
}

/// Range of stored values that mean padding. Some writers give the 16 bits in the other signedness;
/// they are converted to that of the pixels.
std::optional<std::pair<double, double>> padding(vtkDICOMMetaData& meta) {
  const auto first = numbers(meta, 0, DC::PixelPaddingValue, 1);
  if (first.empty()) return {};
  const auto limit = numbers(meta, 0, DC::PixelPaddingRangeLimit, 1);
  const bool is_signed = meta.Get(0, vtkDICOMTag(DC::PixelRepresentation)).AsInt() == 1;
  const auto as_stored = [&](double v) {
    if (is_signed) return v > 32767 ? v - 65536 : v;
    return v < 0 ? v + 65536 : v;
  };
  const double a = as_stored(first[0]);
  const double b = limit.empty() ? a : as_stored(limit[0]);
  return std::pair(std::min(a, b), std::max(a, b));
}

/// The value of an attribute as the end of a message: ", found '0\\0'".
std::string found_attribute(vtkDICOMMetaData& meta, int frame, DC::EnumType tag) {
  const vtkDICOMValue& value = meta.Get(0, frame, vtkDICOMTag(tag));
  const std::string found = value.IsValid() ? value.AsString() : std::string();
  return ", found " + (found.empty() ? std::string("nothing") : "'" + excerpt(found) + "'");
}

/// Reads the geometry of one frame. Returns a defect, or an empty text.
std::string read_slice(vtkDICOMMetaData& meta, DicomSlice& slice, bool& has_rescale) {
  const auto position = numbers(meta, slice.frame, DC::ImagePositionPatient, 3);
  if (position.empty()) {
    return "expected ImagePositionPatient of 3 numbers" +
           found_attribute(meta, slice.frame, DC::ImagePositionPatient);
  }
  const auto orientation = numbers(meta, slice.frame, DC::ImageOrientationPatient, 6);
  if (orientation.empty()) {
    return "expected ImageOrientationPatient of 6 numbers" +
           found_attribute(meta, slice.frame, DC::ImageOrientationPatient);
  }
  const auto spacing = numbers(meta, slice.frame, DC::PixelSpacing, 2);
  if (spacing.empty() || !(spacing[0] > 0 && spacing[1] > 0)) {
    return "expected PixelSpacing of 2 positive numbers" +
           found_attribute(meta, slice.frame, DC::PixelSpacing);
  }
  slice.position_mm << position[0], position[1], position[2];
  slice.row_direction << orientation[0], orientation[1], orientation[2];
  slice.column_direction << orientation[3], orientation[4], orientation[5];
  slice.spacing_mm << spacing[1], spacing[0];  // The tag begins with the row spacing.
  const auto slope = numbers(meta, slice.frame, DC::RescaleSlope, 1);
  const auto intercept = numbers(meta, slice.frame, DC::RescaleIntercept, 1);
  has_rescale = !slope.empty() && !intercept.empty();
  if (!has_rescale &&
      (has(meta, slice.frame, DC::RescaleSlope) || has(meta, slice.frame, DC::RescaleIntercept))) {
    return "expected RescaleSlope and RescaleIntercept, one number each, or neither";
  }
  if (has_rescale && slope[0] == 0) return "expected a RescaleSlope other than 0";
  slice.rescale = {has_rescale ? slope[0] : 1.0, has_rescale ? intercept[0] : 0.0, padding(meta)};
  return {};
}

/// False for a file that its name shows to be a text, a table, an image of another kind or hidden.
bool may_be_slice(const std::filesystem::path& file) {
  const std::string stem = file.filename().string();
  if (stem.empty() || stem.front() == '.') return false;
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  static const std::set<std::string> kOthers{
      ".txt", ".md",  ".csv", ".json", ".xml", ".html", ".htm", ".pdf", ".ini", ".inf",
      ".log", ".png", ".jpg", ".jpeg", ".gif", ".bmp",  ".db",  ".exe", ".dll", ".zip",
      ".gz",  ".mha", ".mhd", ".nrrd", ".nii", ".raw",  ".py",  ".sh",  ".bat", ".toml"};
  return !kOthers.contains(extension) && stem != "LICENSE" && stem != "README";
}

/// Returns a defect of how the samples are stored, or an empty text.
std::string sample_defect(vtkDICOMMetaData& meta) {
  const std::string photometric = text(meta, DC::PhotometricInterpretation);
  if (!photometric.empty() && photometric != "MONOCHROME1" && photometric != "MONOCHROME2") {
    return "PhotometricInterpretation: expected MONOCHROME1 or MONOCHROME2, found " +
           excerpt(photometric);
  }
  const auto stored = numbers(meta, 0, DC::BitsStored, 1);
  const auto high = numbers(meta, 0, DC::HighBit, 1);
  if (!stored.empty() && !high.empty() && high[0] != stored[0] - 1) {
    return "HighBit: expected BitsStored - 1, " + to_text(stored[0] - 1) + ", found " +
           to_text(high[0]);
  }
  // The groups of an enhanced image would replace what a classic one says itself.
  constexpr const char* kClassicCt = "1.2.840.10008.5.1.4.1.1.2";
  if (text(meta, DC::SOPClassUID) == kClassicCt &&
      (meta.Has(vtkDICOMTag(DC::SharedFunctionalGroupsSequence)) ||
       meta.Has(vtkDICOMTag(DC::PerFrameFunctionalGroupsSequence)))) {
    return "expected no functional groups in a classic CT image, found some";
  }
  return {};
}

/// Most bytes that one byte of a codec can stand for: of a blank image, some can shrink all.
double most_expansion(const std::string& transfer_syntax) {
  constexpr double kRunLengths = 64;    // Two bytes for a run of 128.
  constexpr double kLosslessJpeg = 16;  // A bit for a sample of 16 bits.
  constexpr double kJpeg = 512;         // Two bits or more for a block of 64 samples.
  constexpr double kHeaders = 2;        // Headers, and what the estimates above neglect.
  constexpr double kOthers = 1e5;       // JPEG-LS and JPEG 2000.
  if (transfer_syntax == "1.2.840.10008.1.2.5") return kHeaders * kRunLengths;
  for (const char* lossless : {"1.2.840.10008.1.2.4.57", "1.2.840.10008.1.2.4.70"}) {
    if (transfer_syntax == lossless) return kHeaders * kLosslessJpeg;
  }
  for (const char* jpeg : {"1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51"}) {
    if (transfer_syntax == jpeg) return kHeaders * kJpeg;
  }
  return kOthers;
}

/// Counts a file whose pixel data are longer than stated; one byte may pad them to an even length.
void note_longer(vtkDICOMMetaData& meta, vtkDICOMParser& parser, double samples,
                 const std::filesystem::path& file, DicomSeries& series) {
  constexpr unsigned kEncapsulated = 0xffffffffU;
  const unsigned found = parser.GetPixelDataVL();
  const double claimed = samples * meta.Get(0, vtkDICOMTag(DC::BitsAllocated)).AsInt() / 8;
  if (found == kEncapsulated || found <= claimed + 1) return;
  if (series.longer_files++ > 0) return;
  series.first_longer = file.filename().string() + ": " + to_text(claimed) + " bytes stated, " +
                        std::to_string(found) + " found";
}

/// Returns a defect of the pixel-data length, or an empty text. It is checked before a decoder
/// allocates the size that Rows, Columns and NumberOfFrames declare.
std::string length_defect(vtkDICOMMetaData& meta, vtkDICOMParser& parser, double samples) {
  constexpr unsigned kEncapsulated = 0xffffffffU;
  const double expansion = most_expansion(text(meta, DC::TransferSyntaxUID));
  const double claimed = samples * meta.Get(0, vtkDICOMTag(DC::BitsAllocated)).AsInt() / 8;
  auto found = static_cast<double>(parser.GetFileSize() - parser.GetFileOffset());
  const bool encapsulated = parser.GetPixelDataVL() == kEncapsulated;
  if (!encapsulated) found = std::min(found, static_cast<double>(parser.GetPixelDataVL()));
  if (claimed > 0 && claimed <= found * (encapsulated ? expansion : 1)) return {};
  return "pixel data cut short: expected " + to_text(claimed) + " bytes, found " + to_text(found) +
         (encapsulated ? " compressed" : "");
}

void add_file(const InputFile& input, vtkDICOMMetaData& meta, vtkDICOMParser& parser,
              DicomSeries& series) {
  const std::filesystem::path& file = input.path();
  const auto defect = [&](const std::string& what) {
    if (series.defect.empty()) series.defect = file.filename().string() + ": " + what;
  };
  if (!parser.GetPixelDataFound()) return defect("expected pixel data, found none");
  if (text(meta, DC::ImageType).find("LOCALIZER") != std::string::npos) {
    ++series.localizers;
    return;
  }
  const int samples = meta.Get(0, vtkDICOMTag(DC::SamplesPerPixel)).AsInt();
  if (samples != 1) {
    return defect("SamplesPerPixel: expected 1, found " + std::to_string(samples));
  }
  if (const std::string stored = sample_defect(meta); !stored.empty()) return defect(stored);
  const int rows = meta.Get(0, vtkDICOMTag(DC::Rows)).AsInt();
  const int columns = meta.Get(0, vtkDICOMTag(DC::Columns)).AsInt();
  if (rows < 1 || columns < 1) {
    return defect("expected Rows and Columns, found " + std::to_string(rows) + " and " +
                  std::to_string(columns));
  }
  constexpr int kMaxFrames = 100000;
  int frames = 1;
  if (meta.Has(vtkDICOMTag(DC::NumberOfFrames))) {
    frames = meta.Get(0, vtkDICOMTag(DC::NumberOfFrames)).AsInt();
  }
  if (frames < 1 || frames > kMaxFrames) {
    return defect("NumberOfFrames: expected 1 to 100000, found " + std::to_string(frames));
  }
  const std::string unit = text(meta, DC::RescaleType);
  if (is_hounsfield_unit(unit) != series.in_hu()) {
    return defect("RescaleType: expected " + excerpt(series.unit.empty() ? "HU" : series.unit) +
                  " as in the other images of the series, found " + excerpt(unit));
  }
  const std::string length = length_defect(meta, parser, 1.0 * rows * columns * frames);
  if (!length.empty()) return defect(length);
  const std::int64_t begin = parser.GetFileOffset();
  const std::string coded = codestream_defect(
      input, {.transfer_syntax = text(meta, DC::TransferSyntaxUID),
              .pixel_data = begin,
              .bytes = parser.GetFileSize() - begin,
              .rows = rows,
              .columns = columns,
              .frames = frames,
              .bytes_of_sample = meta.Get(0, vtkDICOMTag(DC::BitsAllocated)).AsInt() / 8});
  if (!coded.empty()) return defect(coded);
  note_longer(meta, parser, 1.0 * rows * columns * frames, file, series);
  for (int frame = 0; frame < frames; ++frame) {
    DicomSlice slice;
    slice.file = file;
    slice.frame = frame;
    slice.rows = rows;
    slice.columns = columns;
    constexpr std::array kPhaseTags{DC::AcquisitionNumber,
                                    DC::TemporalPositionIdentifier,
                                    DC::KVP,
                                    DC::ConvolutionKernel,
                                    DC::AcquisitionTime,
                                    DC::ContentTime};
    static_assert(kPhaseTags.size() == kPhaseKeys.size());
    for (std::size_t i = 0; i < kPhaseTags.size(); ++i) slice.phase[i] = text(meta, kPhaseTags[i]);
    slice.frame_of_reference = text(meta, DC::FrameOfReferenceUID);
    const auto gap = numbers(meta, frame, DC::SpacingBetweenSlices, 1);
    slice.stated_gap_mm = gap.empty() ? 0 : std::abs(gap[0]);
    if (frames == 1) slice.instance = parse_int(text(meta, DC::InstanceNumber));
    bool has_rescale = false;
    const std::string wrong = read_slice(meta, slice, has_rescale);
    if (!wrong.empty()) return defect(wrong);
    if (!has_rescale) ++series.without_rescale;
    series.slices.push_back(std::move(slice));
  }
}

/// Adds what an image says of patient, study, modality and position; absent attributes say nothing.
void note_identity(vtkDICOMMetaData& meta, DicomSeries& series) {
  const auto add = [&](DC::EnumType tag, std::set<std::string>& values) {
    std::string value = text(meta, tag);
    if (!value.empty()) values.insert(std::move(value));
  };
  add(DC::PatientID, series.patients);
  add(DC::StudyInstanceUID, series.studies);
  add(DC::Modality, series.modalities);
  add(DC::PatientPosition, series.positions);
}

/// Rejects a series that mixes patients, studies, modalities or positions of the patient.
Result<void> check_identity(const DicomSeries& series, const std::string& name) {
  const auto reject = [&](const std::string& key, std::size_t count, const std::string& found) {
    return Error{ErrorCode::kMalformedData, name + ": expected one " + key + " in the series " +
                                                series.uid + ", found " + std::to_string(count) +
                                                found};
  };
  const auto listed = [](const std::set<std::string>& values) {
    std::string text;
    for (const std::string& value : values) {
      text += (text.empty() ? " (" : ", ") + excerpt(value);
    }
    return text + ")";
  };
  // Who the patients are is nobody's business on a screen.
  if (series.patients.size() > 1) return reject("PatientID", series.patients.size(), "");
  if (series.studies.size() > 1) return reject("StudyInstanceUID", series.studies.size(), "");
  if (series.modalities.size() > 1) {
    return reject("Modality", series.modalities.size(), listed(series.modalities));
  }
  if (series.positions.size() > 1) {
    return reject("PatientPosition", series.positions.size(), listed(series.positions));
  }
  return {};
}

/// Reports that a folder has series of several patients or studies. The values do not name them.
void report_mixed(const std::vector<DicomSeries>& all, const DicomSeries& chosen,
                  const std::string& name, Diagnostics& diagnostics) {
  const auto report = [&](const char* key, std::set<std::string> DicomSeries::*values) {
    std::set<std::string> found;
    std::size_t same = 0;
    for (const DicomSeries& series : all) {
      found.insert((series.*values).begin(), (series.*values).end());
      if (series.*values == chosen.*values) ++same;
    }
    if (found.size() < 2) return;
    diagnostics.report(
        "io.ct", {.subject = name,
                  .key = key,
                  .values = {std::to_string(found.size()) + " different ones among " +
                             std::to_string(all.size()) + " series"},
                  .used = "that of the series " + chosen.uid + ", which " + std::to_string(same) +
                          " of the series have"});
  };
  report("PatientID", &DicomSeries::patients);
  report("StudyInstanceUID", &DicomSeries::studies);
  report("PatientPosition", &DicomSeries::positions);
}

std::string describe(const DicomSeries& series) {
  return series.uid + " (" + (series.modality.empty() ? "no modality" : series.modality) + ", " +
         std::to_string(series.slices.size()) + " slices" +
         (series.in_hu() ? "" : " of " + excerpt(series.unit)) +
         (series.description.empty() ? "" : ", '" + excerpt(series.description) + "'") + ")";
}

std::string describe(const std::vector<DicomSeries>& all) {
  std::string text;
  for (const DicomSeries& series : all) text += (text.empty() ? "" : "; ") + describe(series);
  return text;
}

}  // namespace

Result<std::vector<DicomSeries>> scan_dicom(const std::vector<std::filesystem::path>& files,
                                            const std::string& name, Diagnostics& diagnostics) {
  std::vector<DicomSeries> all;
  std::vector<std::string> others;
  std::map<std::string, std::size_t> index;
  for (const std::filesystem::path& file : files) {
    if (file.filename() == "DICOMDIR") continue;
    // An unreadable file may be a slice, and the stack would be wrong without it.
    const auto input = InputFile::open(file);
    if (!input) return input.error();
    if (!is_dicom(*input)) {
      if (may_be_slice(file)) others.push_back(file.filename().string());
      continue;
    }
    const std::string broken = dicom_structure_defect(*input);
    if (!broken.empty()) return Error{ErrorCode::kMalformedData, file.string() + ": " + broken};
    vtkNew<vtkDICOMMetaData> meta;
    vtkNew<vtkDICOMParser> parser;
    VtkErrors errors;
    errors.watch(parser);
    parser->SetMetaData(meta);
    parser->SetFileName(file.c_str());
    errors.run([&] { parser->Update(); });
    const std::string uid = text(*meta, DC::SeriesInstanceUID);
    if (!errors.first().empty()) {
      return Error{ErrorCode::kMalformedData, file.string() + ": " + errors.first()};
    }
    const bool has_pixels = parser->GetPixelDataFound();
    // Reports, structures and directories have no Rows and are not images.
    if (!has_pixels && !meta->Has(vtkDICOMTag(DC::Rows))) continue;
    const auto [place, fresh] = index.emplace(uid, all.size());
    if (fresh) {
      all.emplace_back();
      all.back().uid = uid;
      all.back().modality = text(*meta, DC::Modality);
      all.back().description = text(*meta, DC::SeriesDescription);
      all.back().unit = text(*meta, DC::RescaleType);
      all.back().tilt_tag = text(*meta, DC::GantryDetectorTilt);
    }
    note_identity(*meta, all[place->second]);
    add_file(*input, *meta, *parser, all[place->second]);
  }
  if (!others.empty()) {
    std::string listed;
    for (std::size_t i = 0; i < std::min<std::size_t>(others.size(), 3); ++i) {
      listed += (i > 0 ? ", " : "") + excerpt(others[i]);
    }
    diagnostics.report("io.ct", {.subject = name,
                                 .key = "files of the folder",
                                 .values = {std::to_string(others.size()) +
                                            " files that are not DICOM: " + listed +
                                            (others.size() > 3 ? ", …" : "")},
                                 .used = "the other files"});
  }
  if (all.empty()) {
    return Error{ErrorCode::kNotFound, name + ": expected DICOM images, found none in " +
                                           std::to_string(files.size()) + " files"};
  }
  return all;
}

Result<DicomSeries> choose_series(std::vector<DicomSeries> all, const std::string& name,
                                  const CtOptions& options, Diagnostics& diagnostics) {
  const auto warn = [&](const char* key, std::vector<std::string> values, std::string used) {
    diagnostics.report(
        "io.ct",
        {.subject = name, .key = key, .values = std::move(values), .used = std::move(used)});
  };
  DicomSeries* best = nullptr;
  for (DicomSeries& series : all) {
    if (!options.series_uid.empty()) {
      if (series.uid == options.series_uid) best = &series;
      continue;
    }
    const auto rank = [](const DicomSeries& one) {
      return std::tuple(one.modality == "CT", one.in_hu(), one.slices.size());
    };
    if (best == nullptr || rank(series) > rank(*best)) best = &series;
  }
  if (best == nullptr) {
    return Error{ErrorCode::kNotFound,
                 name + ": expected the series " + options.series_uid + ", found " + describe(all)};
  }
  if (all.size() > 1 && options.series_uid.empty()) {
    std::vector<std::string> found;
    for (const DicomSeries& series : all) found.push_back(describe(series));
    warn("series", std::move(found), best->uid);
  }
  report_mixed(all, *best, name, diagnostics);
  if (!best->defect.empty()) {
    return Error{ErrorCode::kMalformedData, name + ": " + best->defect};
  }
  if (const auto ok = check_identity(*best, name); !ok) return ok.error();
  if (best->modality != "CT") {
    warn("Modality", {"'" + excerpt(best->modality) + "' (expected CT)"}, "the values as HU");
  }
  if (!best->in_hu()) {
    warn("RescaleType", {excerpt(best->unit) + " (expected HU)"}, "the values as HU");
  }
  std::set<std::string> places;
  for (const DicomSlice& slice : best->slices) {
    if (!slice.frame_of_reference.empty()) places.insert(slice.frame_of_reference);
  }
  if (places.size() > 1) {
    return Error{ErrorCode::kMalformedData, name + ": expected one FrameOfReferenceUID, found " +
                                                std::to_string(places.size()) +
                                                ": positions of slices cannot be compared"};
  }
  if (best->without_rescale > 0 && best->without_rescale < best->slices.size()) {
    return Error{ErrorCode::kMalformedData,
                 name + ": expected RescaleSlope and RescaleIntercept in all of " +
                     std::to_string(best->slices.size()) + " slices or in none, found " +
                     std::to_string(best->without_rescale) + " without"};
  }
  if (best->without_rescale > 0) {
    warn("RescaleSlope, RescaleIntercept",
         {std::to_string(best->without_rescale) + " slices without"}, "the values as HU");
  }
  if (best->longer_files > 0) {
    warn("length of the samples",
         {std::to_string(best->longer_files) + " files with more than stated (" +
          best->first_longer + ")"},
         "the first bytes of each");
  }
  if (best->localizers > 0) {
    warn("ImageType", {std::to_string(best->localizers) + " overview images (LOCALIZER)"},
         "the other images");
  }
  return std::move(*best);
}

}  // namespace nav::io::detail
