#!/bin/sh
# The same with curl: upload, run, wait, fetch the metrics as CSV and a chart that stands alone.
#
#     sh examples/run_marks.sh [SERVER] [FOLDER]     default FILTERROOM_URL, else http://127.0.0.1:8000; results into the present folder
set -eu
server=${1:-${FILTERROOM_URL:-http://127.0.0.1:8000}}
folder=${2:-.}
samples=$(dirname "$0")/recordings
token=${FILTERROOM_TOKEN:-$(cat "${XDG_DATA_HOME:-$HOME/.local/share}/filterroom/token")}

# Calls the API; prints the answer, or the problem to the terminal and ends.
api() {
    path=$1
    shift
    answer=$(curl --silent --show-error --fail-with-body --header "Authorization: Bearer $token" "$@" \
        "$server/api/v1$path") || { echo "$answer" >&2 && exit 1; }
    printf '%s\n' "$answer"
}
# The first value of a field of a JSON answer; `jq -r .FIELD` does it better where jq is installed.
field() { printf '%s' "$2" | tr ',{' '\n\n' | sed -n "s/^ *\"$1\" *: *\"\([^\"]*\)\".*/\1/p" | head -n 1; }

uploaded=$(api /recordings --form "file=@$samples/sample_marks.csv" --form "site=@$samples/sample_site.json")
wanted="{\"recording_id\": \"$(field id "$uploaded")\",
    \"algorithms\": [{\"name\": \"single_mark\"}, {\"name\": \"rdf\"}, {\"name\": \"rdfv\"}]}"
run=$(api /runs --json "$wanted")
id=$(field id "$run")

while :; do
    run=$(api "/runs/$id")
    state=$(field state "$run")
    case $state in queued | running) sleep 1 ;; *) break ;; esac
done
echo "run $id has $state"
[ "$state" = succeeded ]

api "/runs/$id/tables/metrics.csv" >"$folder/metrics.csv"
api "/runs/$id/charts/plan.html" >"$folder/plan.html"
grep -E '^metric|^(rms|claimed)_horizontal_m,' "$folder/metrics.csv"
