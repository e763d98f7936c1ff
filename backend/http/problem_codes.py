"""Every code that an error can carry, with what it means in general; served at /problems/CODE.

A test looks through the sources for codes that are missing here. Plugins may bring codes of their own.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """The kind of a problem: a title that never changes, and what it means in general."""

    title: str
    meaning: str


PROBLEMS: dict[str, Kind] = {
    # The protocol.
    "malformed_request": Kind("The request cannot be taken apart", "The body is not what its headers say it is."),
    "malformed_json": Kind("The body is not JSON", "The body was announced as JSON and is none."),
    "host_not_allowed": Kind(
        "Unknown host name",
        "The request names a host that this server does not answer to; otherwise any site could reach it through "
        "a name of its own. Add your name to FILTERROOM_ALLOWED_HOSTS.",
    ),
    "token_required": Kind(
        "The token is missing",
        "Everything under /api needs the token that `filterroom serve` prints, as `Authorization: Bearer`.",
    ),
    "token_wrong": Kind("The token is wrong", "The token is not the one of this server; it prints it at its start."),
    "forbidden": Kind("Not allowed", "The server understood the request and refuses it."),
    "cross_site": Kind(
        "Another site asked for a change",
        "A browser says that a page of another site sent this request. Only the server's own page and programs "
        "with the token may change anything.",
    ),
    "not_found": Kind("There is nothing here", "No such address, or nothing is stored under this name."),
    "method_not_allowed": Kind("The method is not possible here", "The header `Allow` lists what is possible."),
    "unsupported_media_type": Kind(
        "The body is of a type that is not taken", "The detail names the types that this endpoint takes."
    ),
    "validation": Kind("Something in the request is not as it must be", "`errors` lists each field with its reason."),
    "cursor": Kind("The cursor cannot be used", "Start the list again without it, or keep the filters of its page."),
    "idempotency_key_reused": Kind(
        "The Idempotency-Key was used with another body", "A key stands for one request; make a new one."
    ),
    "internal": Kind("An unexpected error", "The server's log has it, under the number in the detail."),
    # Limits and storage.
    "too_large": Kind("Too large", "The detail names the limit and the setting that holds it."),
    "quota": Kind("Too much at once", "Wait for some of it to finish."),
    "storage": Kind("The data folder cannot be used", "Its disk is full or does not allow writing."),
    "disk_full": Kind("The disk is full", "Free space, or delete runs and recordings; nothing stored is lost."),
    "read_only": Kind("The database takes no changes", "Its disk, its permissions or its server do not allow writing."),
    "database_damaged": Kind("The database is damaged", "Restore the last backup."),
    "database_unreachable": Kind("The database does not answer", "The server tries again by itself."),
    "database_in_use": Kind("Another server uses the database", "Stop it, or use another database."),
    "database_rights": Kind("The database denies the rights", "The role of the server must own the database."),
    "unavailable": Kind("Something that is needed does not answer", "Try again in a moment."),
    "database_locked": Kind("The database is locked", "Another program holds it open for writing."),
    "blob_missing": Kind("A stored file is missing", "Something outside the program removed it from the data folder."),
    "file_not_found": Kind("A file is missing", "It was there a moment ago."),
    # States.
    "state": Kind("Not possible in this state", "The detail names the state."),
    "unknown_target": Kind("No such target", "None of the recordings has it; `GET .../targets` lists those they have."),
    "table_without_targets": Kind(
        "The table does not tell targets apart", "Its rows are of stations or of all marks; ask without `target`."
    ),
    "recording_not_found": Kind("No such recording", "It was deleted, or its id is misspelt."),
    "recording_not_ready": Kind("The recording is still being read", "Wait until its state is `ready`."),
    "recording_failed": Kind("The recording could not be read", "Its `error` says why."),
    "recording_in_use": Kind("Runs use the recording", "Delete them first, or repeat with `runs=delete`."),
    "run_not_found": Kind("No such run", "It was deleted, or its id is misspelt."),
    "run_live": Kind("The run is not finished", "Cancel it first."),
    "run_finished": Kind("The run is finished", "A finished run cannot be cancelled any more."),
    "no_result": Kind("The run has no result", "It is not finished, or it did not succeed."),
    "run_repeated": Kind("A run is named twice", "Each of the compared runs is named once."),
    "recordings_differ": Kind(
        "The runs cannot be drawn into one chart", "They worked on recordings that do not share what the chart needs."
    ),
    "table_not_found": Kind("No such table", "GET /api/v1/runs/ID/tables lists the tables of a run."),
    "chart_not_found": Kind("No such chart", "GET /api/v1/runs/ID/charts lists the charts of a run."),
    # Runs.
    "algorithm_not_found": Kind("No such algorithm", "GET /api/v1/algorithms lists them."),
    "kind_mismatch": Kind(
        "The algorithm does not take this kind of recording", "Its `takes` lists the kinds that it takes."
    ),
    "label_repeated": Kind("A label is used twice", "Charts and tables tell entries apart by their labels."),
    "source_missing": Kind("The run has no source, or several", "Give exactly one."),
    "antenna_direction": Kind(
        "Nobody knows where the antenna looks",
        "Bicone angles need the azimuth and elevation of the antenna's boresight.",
    ),
    "merging_structure": Kind(
        "The merging rule does not fit the structure", "GPB1 has one common state, so no hypothesis is the main one."
    ),
    "region_polygon": Kind(
        "The polygon of a region is none",
        "It needs three distinct corners that are not on one line, and edges that neither cross nor touch.",
    ),
    "transition_size": Kind("The transition matrix has another size", "It has one row and one column for each model."),
    "transition_entry": Kind("A transition probability is none", "Probabilities lie between 0 and 1."),
    "transition_sum": Kind("A row of the transition matrix does not sum to one", "A row says where its model may go."),
    "transition_transposed": Kind(
        "The transition matrix looks transposed",
        "Its columns sum to one and its rows do not; a row is from, a column to.",
    ),
    "transition_root": Kind(
        "The transition matrix cannot be used for these intervals",
        "A chain that has no real root has no probabilities for parts of its base interval.",
    ),
    "site_missing": Kind(
        "The recording has no site",
        "Measured times and frequencies mean nothing without the places of the stations. Read the recording again "
        "with its site.",
    ),
    "trials_of_a_recording": Kind("A recording is one trial", "Many trials need a scenario."),
    "scenario_not_found": Kind("No such scenario", "GET /api/v1/scenarios lists them."),
    "scenario_too_long": Kind("The scenario has too many instants for trials", "Shorten it, or store one recording."),
    "scenario_empty": Kind("The scenario has no measurement", "Lengthen it, or shorten its period."),
    "no_monte_carlo": Kind("The algorithm works on recordings only", "It does not say how its estimates are scored."),
    "sweep_of_a_recording": Kind("A sweep needs a scenario", "On a recording give one entry per value."),
    "sweep_too_large": Kind("The sweep has too many combinations", "Leave values out, or start several runs."),
    "sweep_unknown": Kind("The sweep names no parameter of the run", "Write `<label>.<name>` or `scenario.<name>`."),
    "sweep_repeated": Kind("A value is swept twice", "Each value makes one row; leave the second out."),
    "sweep_not_comparable": Kind("A run with a sweep stands by itself", "Its own tables compare what it varies."),
    "smoothing_too_long": Kind("Too many marks to be smoothed", "Smoothing keeps every covariance in memory."),
    "map_too_large": Kind("The map has too many cells", "Lower the count of an axis, or leave the subsets out."),
    "no_stations": Kind("The site has no stations", "An accuracy map needs two receivers or more."),
    "study_not_found": Kind("No such study", "GET /api/v1/studies lists them."),
    "study_is_whole": Kind("A study brings everything but trials and seed", "Leave the other fields out."),
    "study_mismatch": Kind("The study cannot judge this run", "Its judge did not find a number that it needs."),
    "plots_without_origin": Kind("The plots need an origin", "Latitude and longitude need that of the local frame."),
    "complex_numbers": Kind("The file holds complex numbers", "Columns of a recording are real: save those alone."),
    "no_true_paths": Kind(
        "The recording has no true paths", "They come with a truth file; rows may have truth all the same."
    ),
    "no_tracks": Kind("No track can be a target", "Reports must be two or more, and what they say must be flown."),
    "track_unknown": Kind("The file has no such track", "Leave the names out to see those that it has."),
    "no_free_targets": Kind("The preset has no targets that follow points", "The detail lists those that have."),
    "recording_repeated": Kind("A recording is named twice", "Leave one out: its plots would count twice."),
    "radar_without_place": Kind("A radar of the plots stands nowhere", "The site must name it, or each of its plots."),
    # Data and parameters.
    "input": Kind("The data or the parameters cannot be used", "The detail says which and why."),
    "text": Kind("A text cannot be stored", "It is too long, or holds a character that no database takes."),
    "parameter": Kind("A parameter cannot be used", "The detail names it and its limits."),
    "recording": Kind("The recording cannot serve", "It lacks something that the algorithm needs."),
    "mark_format": Kind("A line of a file is not as it must be", "The detail names line and column."),
    "unsupported_format": Kind("No reader knows this format", "The detail says what was recognised."),
    "frame": Kind("A coordinate is outside of what a conversion can do", "Check units and origin."),
    "algorithm": Kind("The method could not go on", "The detail names the instant and the track."),
    "singular_geometry": Kind("Nothing can be solved from these stations", "They stand on a line, or on one point."),
    "not_positive_definite": Kind("A covariance lost its meaning", "Usually the noise parameters are unrealistic."),
    "site_mismatch": Kind("Site and recording do not fit", "Their stations differ in names or order."),
    "one_radar": Kind("One radar has nothing to be compared with", "The recording has plots of one radar only."),
    "no_usable_plots": Kind("No plot can be used", "Every row lacks a range or an azimuth that means something."),
    "moving_radar": Kind("A radar moves", "Only radars that stand still can be compared with each other."),
    "accuracy_missing": Kind(
        "The accuracy of a radar is unknown", "Neither the site nor the run says how large its errors are."
    ),
    "azimuth_unit": Kind("Azimuths are in another unit", "Some are larger than a full turn."),
    "singular_pair": Kind(
        "Plots that cannot be compared", "Both are unknown along the same line only: the accuracies cannot be right."
    ),
    "integer_program": Kind("The integer program was not solved", "The plots of many radars were not matched."),
    "wavelength_missing": Kind("The site has no wavelength", "Frequencies mean nothing without it."),
    "no_base_line": Kind("There is no base line", "Transmitters and receivers stand at the same place."),
    "site_geometry": Kind(
        "The closed form cannot work with this site", "It takes transmitters on the bisector of the receivers only."
    ),
    "one_doppler": Kind("One Doppler is not enough", "It fits two places on the base line equally well."),
    "azimuth_missing": Kind("The recording has no azimuths", "This algorithm needs them beside the Doppler."),
    "start_covariance": Kind("The start cannot be used", "Its covariance is not symmetric and positive definite."),
    "unknown_algorithm": Kind("A worker does not know the algorithm", "Its version differs from the server's."),
    "out_of_memory": Kind(
        "A worker ran out of memory",
        "Use a shorter recording, or fewer workers; the limit is FILTERROOM_WORKER_MEMORY_BYTES.",
    ),
    "kernels_not_compiled": Kind(
        "The kernels cannot be compiled", "The server's log holds what the compiler said; nothing runs until it can."
    ),
    "worker_died": Kind("A worker died", "Most often for want of memory."),
    # Reading files.
    "no_file": Kind("There is no file", "An upload needs at least one field `file`."),
    "empty_file": Kind("The file is empty", "There is nothing to read in it."),
    "no_header": Kind("There is no line of names", "The first line of a CSV file names its columns."),
    "no_columns": Kind("No column is known", "Rename the columns, or give a `mapping`."),
    "no_rows": Kind("There are no rows", "The file has names of columns and nothing below."),
    "no_usable_rows": Kind("No row can be used", "The detail says what was wrong with them."),
    "missing_column": Kind("A column is missing", "The detail names it; a `mapping` can point to it."),
    "duplicate_column": Kind("A column is there twice", "Remove or rename one of them."),
    "unknown_native_column": Kind("The mapping names an unknown column", "Its keys are the native names."),
    "unit": Kind("The unit does not fit", "The detail lists the units that do."),
    "check_units": Kind("The numbers contradict the site", "Units are wrong, or the site is another one."),
    "encoding": Kind("The text cannot be decoded", "Save the file as UTF-8."),
    "damaged_archive": Kind("The compressed file is damaged", "Compress it again."),
    "expands_too_much": Kind("The compressed file grows too large", "Upload it in parts."),
    "damaged_file": Kind("The file is damaged", "Save it again and upload it whole."),
    "no_table": Kind("There is no table in the file", "The detail says what it holds."),
    "archive_members": Kind("The archive does not hold what it should", "The detail says what it holds."),
    "format_unknown": Kind("There is no reader of this name", "The detail lists the readers."),
    "kind_unknown": Kind("The kind of measurements is not clear", "Give the option `kind`, or a `mapping`."),
    "kind_ambiguous": Kind("The columns fit several kinds", "Give the option `kind`."),
    "kind_unfit": Kind("The format does not hold this kind", "Leave the option `kind` out."),
    "mixed_kinds": Kind("The files hold different kinds", "Upload each kind by itself."),
    "mixed_channels": Kind("The files have different channels", "Upload each by itself."),
    "mixed_time_bases": Kind("The times do not count from the same instant", "Give all of them the same times."),
    "doppler_channels": Kind("The channels are not a complete set", "The detail lists the complete ones."),
    "where_matches_nothing": Kind("No row fits the filter", "Compare the values of `where` with the file."),
    "origin_missing": Kind("The origin is missing", "WGS-84 positions need an origin of the local frame."),
    "origin_twice": Kind("Two origins are given", "Give it in the options or in the site."),
    "truth_missing": Kind("The truth file has no truth", "It needs time and position columns."),
    "truth_twice": Kind("The truth is given twice", "Keep the local one or the WGS-84 one."),
    "site_json": Kind("The site is not JSON", "It begins like JSON and cannot be parsed."),
    "site_invalid": Kind("The site cannot be used", "The detail names the field."),
    "site_kind": Kind("The site is for another kind of recording", "The detail says what is needed."),
    "site_large": Kind("The site is too large", "Keep only the stations in use."),
    "station_unknown": Kind("Stations are not in the site", "Names in recording and site must be the same."),
    "truth_only": Kind("The file holds paths, not measurements", "Give it as `truth` beside the measurements."),
    "edition_unknown": Kind("There is no such edition", "The detail lists the editions that are known."),
    "no_asterix": Kind("The capture carries no ASTERIX", "Capture the ports of the radar."),
    "period_unknown": Kind("Nothing tells the period of a turn", "Give `scan_period_s`."),
    "radar_unknown": Kind("Radars are not in the site", "Names in recording and site must be the same."),
    "too_few_stations": Kind("There are too few stations", "The detail says how many are needed."),
    "unreadable": Kind("The file could not be read", "The detail says why."),
    "reader_died": Kind("Reading ended without an answer", "The file may be damaged, or too large for the memory."),
    "reader_timeout": Kind("Reading took too long", "The limit is the setting FILTERROOM_READER_TIMEOUT_S."),
    "reader_busy": Kind("The reader is busy", "Files are read one after the other; try again in a moment."),
    "reader_memory": Kind("Reading needs too much memory", "The limit is FILTERROOM_READER_MEMORY_BYTES."),
    # Starting the program.
    "data_folder_in_use": Kind("Another server uses the data folder", "Stop it, or use another folder."),
    "no_data": Kind("There is no data folder", "Give the folder that a server has used, with --data."),
    "database_newer": Kind("A newer version has written the database", "Install that version."),
    "database_url": Kind("The database's address cannot be used", "The detail says why."),
    "migration": Kind("The migration was undone", "Nothing was changed."),
    "port": Kind("The address cannot be listened on", "The detail says why."),
    "scheduler_address": Kind("The scheduler's address cannot be used", "The detail says why."),
    "scheduler_unreachable": Kind("The scheduler does not answer", "The server tries again by itself; runs wait."),
    "token_empty": Kind("The file of the token is empty", "Remove it or write a secret into it."),
    "os_error": Kind("The operating system refused", "The detail says what."),
    "usage": Kind("The command line cannot be understood", "`filterroom --help` lists what can be said."),
}
