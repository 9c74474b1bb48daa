# Everything on one web page that needs nothing else: results/<study>/report.html.


def study_texts():
    """Study files as they were written, and what the command line changed in them."""
    texts, merged = {}, {}
    for path in map(Path, workflow.configfiles):
        texts[path.name] = path.read_text(encoding="utf-8")
        merged |= yaml.safe_load(texts[path.name])
    changed = {key: value for key, value in config.items() if merged.get(key) != value}
    if changed:
        texts["changes on the command line"] = yaml.safe_dump(changed, sort_keys=False)
    return texts


def benchmark_files():
    """Benchmark files of the jobs that make the study as it is now, by rule."""
    files = {
        "curves": expand(rules.curves.benchmark, block=BLOCKS),
        "points": expand(rules.points.benchmark, block=READINGS),
        "stiction": [rules.stiction.benchmark],
        "scan": expand(rules.scan.benchmark, scan=STUDY.scans),
        "scans": [rules.scans.benchmark] if STUDY.scans else [],
        "states": [rules.states.benchmark] if STUDY.states else [],
        "comparisons": [rules.comparisons.benchmark] if STUDY.comparisons else [],
        "claims": [rules.claims.benchmark] if STUDY.claims else [],
        "figure": expand(rules.figure.benchmark, figure=STUDY.figures),
    }
    return {rule: [str(path) for path in paths] for rule, paths in files.items()}


rule report:
    input:
        stiction=f"{RESULTS}/tables/stiction.parquet",
        scans=f"{RESULTS}/tables/scans.parquet" if STUDY.scans else [],
        states=f"{RESULTS}/tables/states.parquet" if STUDY.states else [],
        comparisons=f"{RESULTS}/tables/comparisons.parquet" if STUDY.comparisons else [],
        claims=f"{RESULTS}/tables/claims.parquet" if STUDY.claims else [],
        svg=expand(f"{RESULTS}/figures/{{figure}}.svg", figure=STUDY.figures),
        png=expand(f"{RESULTS}/figures/{{figure}}.png", figure=STUDY.figures),
        code=sources("report", "tables", "files", "jobs"),
    output:
        f"{RESULTS}/report.html",
    log:
        f"{RESULTS}/logs/report.log",
    benchmark:
        f"{RESULTS}/benchmarks/report.tsv"
    localrule: True
    threads: 1
    params:
        study=STUDY.name,
        captions={name: figure.get("caption", "") for name, figure in STUDY.figures.items()},
        study_files=study_texts(),
        benchmarks=benchmark_files(),
    message:
        "putting everything on one page"
    script:
        "../scripts/report.py"
