# The page of app/demo.sh, from the results in the current folder. Shell and awk are all it needs.

# The first value of a key in JSON that the program wrote (one key a line); empty if it is null or missing.
text_value() {
  awk -v key="\"$2\":" '$1 == key { sub(/^[^:]*: */, ""); sub(/,$/, ""); gsub(/^"|"$/, "");
                                    if ($0 != "null") print; exit }' "$1"
}

# The same as a number times a factor, with a number of decimals; "unknown" where there is none.
scaled() {
  text_value "$3" "$4" | LC_ALL=C awk -v factor="$1" -v decimals="$2" '
    { value = sprintf("%.*f", decimals, $1 * factor); known = 1 }
    value + 0 == 0 { sub(/^-/, "", value) }  # a rounded zero has no sign
    END { printf "%s", known ? value : "unknown" }'
}

rounded() { scaled 1 "$@"; }

html() { printf '%s' "$*" | sed 's/&/\&amp;/g; s/</\&lt;/g; s/>/\&gt;/g; s/"/\&quot;/g'; }

# "4 red, 2 orange" from a detections.csv.
found_by_class() {
  awk -F, 'NR > 1 { if (!($5 in count)) order[++classes] = $5; count[$5]++ }
           END { if (!classes) printf "nothing"
                 for (i = 1; i <= classes; ++i)
             printf "%s%d %s", (i == 1 ? "" : ", "), count[order[i]], order[i] }' "$1"
}

# A CSV file as a table: the named columns, numbers with four significant digits.
csv_table() {
  local file=$1
  shift
  LC_ALL=C awk -F, -v columns="$*" '
    function escaped(text) { gsub(/&/, "\\&amp;", text); gsub(/</, "\\&lt;", text); return text }
    function cell(text) { return text ~ /^-?[0-9]+\.[0-9]/ || text ~ /e-/ ? sprintf("%.4g", text) : escaped(text) }
    BEGIN { wanted = split(columns, names, " "); print "<table>" }
    NR == 1 { for (i = 1; i <= NF; ++i) place[$i] = i }
    { printf "<tr>"
      for (i = 1; i <= wanted; ++i) {
        tag = NR == 1 ? "th" : "td"
        printf "<%s>%s</%s>", tag, NR == 1 ? names[i] : cell($place[names[i]]), tag
      }
      print "</tr>" }
    END { print "</table>" }' "$file"
}

demo_page() {
  cat <<HTML
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>ballservo: the demo</title>
<style>
body { font: 16px/1.5 sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1, h2 { line-height: 1.2; }
h2 { margin-top: 2.5rem; border-top: 1px solid #ccc; padding-top: 1rem; }
img, video { max-width: 100%; height: auto; border: 1px solid #ccc; }
.pair { display: flex; gap: 1rem; flex-wrap: wrap; }
.pair figure { flex: 1 1 20rem; margin: 0; }
figcaption { color: #555; font-size: 0.9rem; }
table { border-collapse: collapse; font-size: 0.9rem; display: block; overflow-x: auto; }
th, td { border: 1px solid #ccc; padding: 0.2rem 0.6rem; text-align: right; }
th { background: #f3f3f3; }
.big { font-size: 1.2rem; }
</style>
</head>
<body>
<h1>A robot sees a ball, places it in 3-D and drives to it</h1>
<p class="big">Five steps, each from its own input to its own result: real photographs for the camera and the colours, a
simulated robot for the drive. Everything on this page was computed on this machine just now, and every file it links to
lies beside it.</p>

<h2>1. The camera</h2>
<p>A camera measures directions once it is known how its lens bends them. That was found from
$(html "$(text_value left.json used)") of $(html "$(text_value left.json images)") photographs of a chessboard.
The board's corners come to lie within <b>$(rounded 3 left.json rms_px) px</b> (root mean square) of where the model says,
and within $(rounded 3 left.json held_out_rms_px) px on photographs that were left out of the fit.
The focal length is <b>$(rounded 1 left.json fx_px) px</b>. What is still uncertain about this camera would move a ball of
70 mm at a distance of 1 m by $(rounded 1 left.json ball_sigma_covered_mm) mm where the board was seen, and by up to
$(rounded 0 left.json ball_sigma_mm) mm in the picture's corners, where it never was (one standard deviation).</p>
<div class="pair">
$(for picture in boards/board_01.png boards/board_10.png; do
    [ -e "$picture" ] || continue
    printf '<figure><img src="%s" alt="a chessboard with its corners">' "$picture"
    printf '<figcaption>Corners as found; red: what is left of each, 50 times enlarged.</figcaption></figure>\n'
  done)
</div>
<p>Files: <a href="boards/report.html">boards/report.html</a> (how far this camera can be trusted),
<a href="left.yaml">left.yaml</a> (the camera, as ROS reads it), <a href="left.json">left.json</a> (all figures).</p>

<h2>2. The colours</h2>
<p>Nobody said which colours there are. Regions of even colour were looked for in one photograph of sweets; those that are
round count as balls, and the colours inside them become classes, each named by its plain word. The result is one table
that tells for any pixel to which class its colour belongs.</p>
<figure><img src="colors/smarties_figure.png" alt="how the colours were learnt, step by step">
<figcaption>From the photograph to the classes.</figcaption></figure>
<p>Files: <a href="smarties.colors">smarties.colors</a> (the table), <a href="colors.json">colors.json</a> (what was learnt
from which disc).</p>

<h2>3. The balls in a picture</h2>
<p>With that table the discs of the learnt colours are found again: <b>$(html "$(found_by_class detections.csv)")</b>.
Nearly black sweets have no colour to go by and are left alone, and so is a disc of which the picture's edge leaves too
little.</p>
<div class="pair">
<figure><img src="found/smarties.png" alt="the photograph with the discs outlined">
<figcaption>What was found, drawn into the photograph.</figcaption></figure>
<figure><img src="stages/smarties_stages.png" alt="the stages of the search">
<figcaption>How it was found, stage by stage.</figcaption></figure>
</div>
$(csv_table detections.csv class quality cx_px cy_px r_px)
<p>File: <a href="detections.csv">detections.csv</a> (all figures).</p>

<h2>4. The drive</h2>
<p>A simulated robot looks through rendered camera pictures, with noise, blur and delay, finds the red ball in each, places
it in 3-D and steers until it stands 0.8 m away and faces it. How that went:
<b>$(html "$(text_value servo/summary.json outcome)")</b>, settled after
<b>$(rounded 1 servo/summary.json settled_s) s</b>, in the end $(scaled 1000 1 servo/summary.json range_error_m) mm off in
distance and $(scaled 57.29577951308232 2 servo/summary.json bearing_error_rad) degrees off in direction.</p>
<video controls preload="metadata" src="servo/video.mp4"></video>
<p>More: <a href="servo/report.html">the run's own page</a> (top view, errors, commands),
<a href="servo/log.csv">log.csv</a>, <a href="servo/summary.json">summary.json</a>.</p>

<h2>5. Is one step enough?</h2>
<p>On line, the outline of a ball is refined by a single step of Gauss and Newton. Off line, Ceres takes as many as it
likes, on the same pixels. So far apart are the two answers, as medians over rendered pictures under several conditions
(<code>paper</code>: the paper's fit of a circle; <code>sphere</code>: the exact fit of a sphere, which the program
uses):</p>
$(csv_table compare/pairs.csv condition method_a method_b frames center_median_px radius_median_px position_median_mm)
<p>More: <a href="compare/report.html">the comparison's own page</a>, <a href="compare/compare.csv">compare.csv</a> (every
method against the exact truth), <a href="compare/pairs.csv">pairs.csv</a>.</p>

<p>How it was all run: <a href="demo.log">demo.log</a> holds each command and what it said.</p>
</body>
</html>
HTML
}
