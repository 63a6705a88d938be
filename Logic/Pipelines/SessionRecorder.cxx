#include "Pipelines/SessionRecorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "Adapters/OpenCv/ImageSequence.h"
#include "Adapters/Rendering/ImageEncoding.h"
#include "CaseIO/AtomicFile.h"
#include "Core/Errors.h"
#include "Pipelines/Report.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

constexpr int kJpegQuality = 95;

void Link(const std::string& from, const std::string& to) {
  std::error_code error;
  fs::create_hard_link(from, to, error);
  if (!error) return;
  // Another file system. Not fs::copy_file: of a full disk it says "Input/output error".
  const auto unreadable = [&] {
    return InputError(from, "", std::string("cannot be read: ") + std::strerror(errno));
  };
  std::ifstream in(from, std::ios::binary);
  if (!in) throw unreadable();
  std::ofstream out(to, std::ios::binary);
  std::string some(std::size_t(1) << 20, '\0');
  while (in.read(some.data(), static_cast<std::streamsize>(some.size())) || in.gcount() > 0)
    WriteThrough(&out, to, some.substr(0, static_cast<std::size_t>(in.gcount())));
  if (in.bad()) throw unreadable();
  out.close();
  if (!out || fs::file_size(to, error) != fs::file_size(from, error) || error)
    throw InputError(to, "", "could not be written completely");
}

/// Place for the pictures, and what ran. @return with the name of the video, where it is one
SessionFolder Begun(SessionFolder session, const std::string& video_file) {
  if (!video_file.empty()) {
    session.source = "video" + fs::path(video_file).extension().string();
    Link(video_file, session.root + '/' + session.source);
  } else {
    const std::string frames = session.root + "/frames";
    std::error_code error;
    fs::create_directories(frames, error);
    if (error) throw InputError(frames, "", "cannot be made: " + error.message());
  }
  WriteSession(session);
  return session;
}

void Line(std::ofstream* file, const std::string& path, const std::string& line) {
  WriteThrough(file, path, line + '\n');
}

}  // namespace

std::uint64_t StateChecksum(const RegistrationState& state) {
  std::uint64_t hash = 1469598103934665603ull;  // FNV-1a over 64-bit words
  const auto add = [&](std::uint64_t word) { hash = (hash ^ word) * 1099511628211ull; };
  add(state.mesh.TetCount());
  for (Index i = 0; i < state.positions.size(); ++i) {
    std::uint64_t word;
    std::memcpy(&word, state.positions.data() + i, sizeof word);
    add(word);
  }
  for (Index i = 0; i < state.mesh.tets.size(); ++i) add(state.mesh.tets.data()[i]);
  return hash;
}

std::string StateLine(const SessionFrame& frame, const RegistrationState& state) {
  return fmt::format("{},{},{:.3f},{},{},{:016x}", frame.frame, ToString(frame.reliability.state),
                     frame.reliability.score, state.mesh.VertexCount(), state.mesh.TetCount(),
                     StateChecksum(state));
}

SessionRecorder::SessionRecorder(const SessionFolder& session, const CameraModel& camera,
                                 const SurfaceMesh& uncut, const std::string& video_file,
                                 const JournalData& registration)
    : session_(Begun(session, video_file)), results_(session.root, camera, uncut, false) {
  frames_.open(Path("frames.csv"), std::ios::binary);
  states_.open(Path("states.csv"), std::ios::binary);
  Line(&frames_, Path("frames.csv"), "frame,source_frame,time_s");
  Line(&states_, Path("states.csv"), "frame,gate,score,vertices,tetrahedra,checksum");
  results_.GetJournal().Write(0.0, 0, "start",
                              {{"program", "kerf"},
                               {"version", KERF_VERSION},
                               {"baseline", KERF_BASELINE},
                               {"case", session_.pseudonym},
                               {"source", session_.source_name},
                               {"cuts", session_.hold_cuts ? "to be accepted" : "automatic"},
                               {"notice", "research use, not a medical device"}});
  results_.GetJournal().Write(0.0, 0, "registration accepted", registration);
}

Frame SessionRecorder::Record(const CapturedFrame& captured, int number, double time_s) {
  Frame frame = captured.frame;
  frame.index = number;
  frame.time_s = time_s;
  if (session_.source.empty() && frame.image) {
    const std::string path = Path(fmt::format("frames/{:06d}.jpg", number));
    WritePicture(path, EncodeJpeg(*frame.image, kJpegQuality));
    std::optional<Image> recorded = ReadImageFile(path);
    if (!recorded) throw InputError(path, "", "cannot be read back");
    frame.image = std::make_shared<const Image>(std::move(*recorded));
  }
  Line(&frames_, Path("frames.csv"),
       fmt::format("{},{},{:.9f}", number, captured.frame.index, time_s));
  return frame;
}

void SessionRecorder::Registered(const SessionFrame& frame, const RegistrationState& state) {
  results_.AddFrame(frame, state, 0.0, 0.0);
  Line(&states_, Path("states.csv"), StateLine(frame, state));
  // Cuts are kept as they come: a session that broke off is taken up again with them. Proposals
  // are none of them.
  std::string cuts;
  for (std::size_t i = 0; i < state.cuts.size(); ++i)
    if (!state.cuts[i].held)
      cuts += fmt::format("{}:{}{} ", i, state.cuts[i].line.points.rows(),
                          state.cuts[i].rejected ? "r" : "");
  if (cuts == cuts_written_) return;
  results_.WriteCuts(state);
  cuts_written_ = cuts;
}

void SessionRecorder::Say(double time_s, int next_frame, const std::string& event,
                          const JournalData& data) {
  results_.GetJournal().Write(time_s, next_frame, event, data);
}

void SessionRecorder::Finish(const RegistrationState& state, const SessionFrame& last) {
  results_.Finish(state);
  results_.GetJournal().Write(last.time_s, last.frame, "end",
                              {{"frames", last.frame + 1},
                               {"cuts", int(results_.Cuts().size())},
                               {"gate", ToString(last.reliability.state)}});
  WriteSessionReport(session_, results_, state);
  session_.finished = true;
  WriteSession(session_);
}

void WriteSessionReport(const SessionFolder& session, const ResultsWriter& results,
                        const RegistrationState& state) {
  ReportData data;
  data.study = "session " + fs::path(session.root).filename().string() + " of " + session.pseudonym;
  data.method = "kerf";
  for (const std::string& picture : KeptPictures(session.root)) {
    const std::string name = fs::path(picture).stem().string();
    ReportSnapshot snapshot;
    if (name.rfind("time_", 0) == 0) {  // time_00012.345.png: was not registered
      snapshot.frame = -1;
      snapshot.time_s = std::atof(name.substr(5).c_str());
    } else if (name.size() > 6) {
      snapshot.frame = std::atoi(name.substr(6).c_str());
    }
    for (const ReliabilityRow& row : results.ReliabilityRows())
      if (row.frame == snapshot.frame) snapshot.time_s = row.time_s;
    snapshot.image = ReadPng(picture);
    data.snapshots.push_back(std::move(snapshot));
  }
  std::stable_sort(
      data.snapshots.begin(), data.snapshots.end(),
      [](const ReportSnapshot& a, const ReportSnapshot& b) { return a.time_s < b.time_s; });
  data.timing = results.Timing();
  data.reliability = results.ReliabilityRows();
  data.cuts = results.Cuts();
  data.final_mesh = MeasureQuality(state.mesh, state.positions);
  data.parameters = {{"source", session.source_name},
                     {"features wanted", std::to_string(session.wanted_features)},
                     {"cuts", session.hold_cuts ? "to be accepted" : "automatic"}};
  data.versions = {{"kerf", KERF_VERSION}, {"instruction set", KERF_BASELINE}};
  WriteReport(session.root + "/report.html", data);
}

}  // namespace kerf
