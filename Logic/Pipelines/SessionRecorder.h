#pragma once

#include <fstream>
#include <memory>

#include "Pipelines/ResultsWriter.h"
#include "Pipelines/SessionFolder.h"
#include "Session/IntraoperativeWorker.h"

namespace kerf {

/// Records a session into its folder while it runs: the frames that are registered, journal.jsonl,
/// frames.csv, states.csv (gate and a checksum of the model after each frame); results as of
/// `kerf replay` at the end. A video file is linked, not encoded again; the pictures of all other
/// sources become JPEGs, and what is registered is the picture as it was recorded.
class SessionRecorder : public IntraoperativeSink {
 public:
  /// @param video_file the source's path where it is a video file, else empty
  /// @throws InputError when the folder cannot be written
  SessionRecorder(const SessionFolder& session, const CameraModel& camera, const SurfaceMesh& uncut,
                  const std::string& video_file, const JournalData& registration);

  Frame Record(const CapturedFrame& captured, int number, double time_s) override;
  void Registered(const SessionFrame& frame, const RegistrationState& state) override;
  void Say(double time_s, int next_frame, const std::string& event,
           const JournalData& data) override;
  void Finish(const RegistrationState& state, const SessionFrame& last) override;

 private:
  std::string Path(const std::string& name) const { return session_.root + "/" + name; }
  SessionFolder session_;
  ResultsWriter results_;
  std::ofstream frames_, states_;
  std::string cuts_written_;  ///< which cuts, in which state
};

/// Checksum of the model: positions and topology, bit by bit.
std::uint64_t StateChecksum(const RegistrationState& state);
/// A line of states.csv without its end: frame,gate,score,vertices,tetrahedra,checksum.
std::string StateLine(const SessionFrame& frame, const RegistrationState& state);

/// The report of a session: journal, gate, times and cuts, with the surgeon's snapshots.
/// @param snapshots folder of PNG pictures, may not exist
void WriteSessionReport(const SessionFolder& session, const ResultsWriter& results,
                        const RegistrationState& state);

}  // namespace kerf
