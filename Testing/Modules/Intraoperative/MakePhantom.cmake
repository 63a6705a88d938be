# Makes the phantom study unless it is there already.
if(EXISTS "${OUTPUT}/video.mp4")
  return()
endif()
execute_process(COMMAND "${KERF}" phantom --scenario kidney-cut --output "${OUTPUT}" RESULT_VARIABLE status)
if(status)
  message(FATAL_ERROR "kerf phantom: ${status}")
endif()
