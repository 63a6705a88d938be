#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "CaseIO/ResultsFiles.h"
#include "Registration/MethodOptions.h"

namespace kerf {

/// A recorded session, CASE/sessions/<time> (layout: docs/tutorial/intraoperative.md). What is
/// written while it runs is appended and flushed line by line; a crash loses what was not said yet
/// and nothing else.
struct SessionFolder {
  static constexpr int kSchema = 1;
  std::string root;
  std::string case_folder;  ///< the case it belongs to
  std::string source;       ///< name of the video file inside the session; empty: frames/%06d.jpg
  std::string source_name;  ///< as the surgeon opened it, without its folder
  std::string pseudonym;
  double frames_per_second = 25.0;
  bool hold_cuts = false;  ///< at the start
  int wanted_features = 225;
  bool finished = false;  ///< it was closed in order
};

/// A new, empty folder sessions/<time> in the case, with `-2` … where the time is taken.
/// @throws InputError when it cannot be made
std::string MakeSessionFolder(const std::string& case_folder, const std::string& time);
bool IsSessionFolder(const std::string& folder);
void WriteSession(const SessionFolder& session);
/// @throws InputError naming file and key; a newer schema is refused
SessionFolder ReadSession(const std::string& folder);
/// Sessions of a case in which at least one frame was recorded, newest first.
std::vector<std::string> RecordedSessions(const std::string& case_folder);
/// Sessions of a case that were not closed in order (a crash, a power cut), newest first.
std::vector<std::string> UnfinishedSessions(const std::string& case_folder);

/// Writes a picture of a session. Where that fails nothing is left of it: half a picture would be
/// taken for one. @throws InputError naming `path`, with the system's reason
void WritePicture(const std::string& path, const std::vector<std::uint8_t>& bytes);

/// The surgeon's snapshots, in the order in which they were kept: of one picture there may be
/// several, `frame_000123.png`, `frame_000123-2.png` … `-10.png`.
std::vector<std::string> KeptPictures(const std::string& session_folder);

/// frames.csv: which frames were registered.
struct RecordedFrame {
  int number = 0;        ///< as registered, 0, 1, 2 …
  int source_frame = 0;  ///< as the source counted
  double time_s = 0.0;   ///< since the first one
};
/// Complete lines only: what a crash cut off is left out. @throws InputError
std::vector<RecordedFrame> ReadRecordedFrames(const std::string& session_folder);

}  // namespace kerf
