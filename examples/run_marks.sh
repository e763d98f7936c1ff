#!/bin/sh
# The same with curl: upload, run, wait, fetch the metrics as CSV and a chart that stands alone.
#
#     sh examples/run_marks.sh [SERVER] [FOLDER]     default http://127.0.0.1:8000, results into the present folder
set -eu
server=${1:-http://127.0.0.1:8000}
folder=${2:-.}
samples=$(dirname "$0")/recordings
token=${FILTERROOM_TOKEN:-$(cat "${XDG_DATA_HOME:-$HOME/.local/share}/filterroom/token")}

api() {
    path=$1
    shift
    curl --silent --show-error --fail-with-body --header "Authorization: Bearer $token" "$@" "$server/api/v1$path"
}
# The first value of a field of the answer; `jq -r .FIELD` does it better where jq is installed.
field() { tr ',{' '\n\n' | sed -n "s/^ *\"$1\" *: *\"\([^\"]*\)\".*/\1/p" | head -n 1; }

recording=$(api /recordings --form "file=@$samples/sample_marks.csv" --form "site=@$samples/sample_site.json" |
    field id)
run=$(api /runs --json "{\"recording_id\": \"$recording\",
    \"algorithms\": [{\"name\": \"single_mark\"}, {\"name\": \"rdf\"}, {\"name\": \"rdfv\"}]}" | field id)

while :; do
    state=$(api "/runs/$run" | field state)
    case $state in queued | running) sleep 1 ;; *) break ;; esac
done
echo "run $run has $state"
[ "$state" = succeeded ]

api "/runs/$run/tables/metrics.csv" --output "$folder/metrics.csv"
api "/runs/$run/charts/plan.html" --output "$folder/plan.html"
grep -E '^metric|^(rms|claimed)_horizontal_m,' "$folder/metrics.csv"
