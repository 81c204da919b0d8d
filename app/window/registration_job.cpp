// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/registration_job.hpp"

#include <QCoreApplication>
#include <QFileInfo>
#include <QStandardPaths>
#include <iomanip>
#include <sstream>

#include "app/options/option.hpp"

namespace nav::app {
namespace {

std::string numbers_text(const auto& numbers) {
  std::ostringstream text;
  text << std::setprecision(17);
  const char* gap = "";
  for (const double number : numbers) text << std::exchange(gap, " ") << number;
  return text.str();
}

/// The program sonde, beside this one or in the PATH.
QString sonde_program() {
  const QString beside = QCoreApplication::applicationDirPath() + QStringLiteral("/sonde");
  return QFileInfo::exists(beside) ? beside : QStringLiteral("sonde");
}

}  // namespace

Result<std::vector<std::string>> register_words(const SessionConfig& config,
                                                const std::optional<Eigen::Matrix4d>& start,
                                                const std::optional<Eigen::Vector3d>& target,
                                                const std::filesystem::path& json) {
  if (config.source.recording.empty()) {
    return Error{ErrorCode::kUsage,
                 "A registration by the sweep needs a recording: open one, or record the devices "
                 "first."};
  }
  if (config.ct.path.empty()) {
    return Error{ErrorCode::kUsage,
                 "A registration by the sweep needs a CT that was read from "
                 "a file."};
  }
  Settings settings;
  settings.config = config;
  const Settings usual = default_settings("register");
  std::vector<std::string> words{"register", config.source.recording.string()};
  for (const Option* option : options_of("register")) {
    const bool of_input = option->key.starts_with("ct.") || option->key.starts_with("source.");
    if (!of_input || is_argument(*option) || option->slot == nullptr) continue;
    const std::string value = value_text(*option, settings);
    if (value == value_text(*option, usual)) continue;
    words.push_back(option->name);
    if (!is_flag(*option)) words.push_back(value);
  }
  if (start) {
    words.insert(words.end(),
                 {"--ct-from-reference", numbers_text(start->reshaped<Eigen::RowMajor>())});
  }
  if (target) {
    words.push_back("--target");
    for (const double mm : *target) words.push_back(numbers_text(std::array{mm}));
  }
  words.insert(words.end(), {"--json", json.string()});
  return words;
}

RegistrationJob::RegistrationJob() = default;

void RegistrationJob::start(const std::vector<std::string>& words) {
  rest_.clear();
  last_.clear();
  process_ = new QProcess;
  QStringList arguments;
  for (const std::string& word : words) arguments.append(QString::fromStdString(word));
  QProcessEnvironment environment = QProcessEnvironment::systemEnvironment();
  environment.insert(QStringLiteral("SONDE_PROGRESS"), QStringLiteral("lines"));
  process_->setProcessEnvironment(environment);
  process_->setProcessChannelMode(QProcess::MergedChannels);
  QObject::connect(process_, &QProcess::readyRead, process_, [this] { read(); });
  QObject::connect(process_, &QProcess::finished, process_,
                   [this](int code, QProcess::ExitStatus status) {
                     finish(status == QProcess::NormalExit ? code : -1);
                   });
  QObject::connect(process_, &QProcess::errorOccurred, process_,
                   [this](QProcess::ProcessError error) {
                     if (error != QProcess::FailedToStart) return;
                     last_ = QStringLiteral("the program sonde cannot be started");
                     finish(-1);
                   });
  process_->start(sonde_program(), arguments);
}

void RegistrationJob::cancel() {
  if (process_ == nullptr) return;
  QProcess* ended = std::exchange(process_, nullptr);
  ended->disconnect();
  // Its end is not waited for; the system takes its memory back at once.
  QObject::connect(ended, &QProcess::finished, ended, &QObject::deleteLater);
  ended->kill();
}

void RegistrationJob::read() {
  rest_ += process_->readAll();
  while (true) {
    const auto end = rest_.indexOf('\n');
    if (end < 0) return;
    const QString line = QString::fromUtf8(rest_.left(end)).trimmed();
    rest_.remove(0, end + 1);
    const QString word = line.section(QLatin1Char(' '), 0, 0);
    if (word == QLatin1String("progress")) {
      if (progressed) {
        progressed(line.section(QLatin1Char(' '), 1, 1).toDouble() / 100,
                   line.section(QLatin1Char(' '), 2));
      }
    } else if (!line.isEmpty()) {
      last_ = line;
    }
  }
}

void RegistrationJob::finish(int exit_code) {
  if (process_ == nullptr) return;
  read();
  std::exchange(process_, nullptr)->deleteLater();
  if (done) done(exit_code, last_);
}

}  // namespace nav::app
