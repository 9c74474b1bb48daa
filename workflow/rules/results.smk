# From the tables to figures, verdicts, summary and report.
TABLES = {name: f"{RESULTS}/tables/{name}.parquet" for name in STUDY.tables}
COMPUTED = {name: path for name, path in TABLES.items() if name != "claims"}
STUDY_PARTS = {name: STUDY.part(name) for name in STUDY.tables}
# Inputs of each figure, with its caption.
FIGURES = STUDY.figure_params


rule figures:
    input:
        **COMPUTED,
        scripts=[figure["script"] for figure in FIGURES.values() if figure["script"]],
    output:
        report(
            expand(f"{RESULTS}/figures/{{figure}}.png", figure=STUDY.figures),
            category="Figures",
        ),
        [f"{RESULTS}/{file}" for file in STUDY.figure_files if not file.endswith(".png")],
        captions=f"{RESULTS}/figures/captions.md",
    log:
        f"{RESULTS}/logs/figures.log",
    benchmark:
        f"{RESULTS}/benchmarks/figures.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        study=STUDY.name,
        figures=FIGURES,
        study_parts=STUDY_PARTS,
        code=STUDY_CODE,
    message:
        "drawing the figures"
    script:
        "../scripts/figures.py"


rule claims:
    input:
        **COMPUTED,
    output:
        table=f"{RESULTS}/tables/claims.parquet",
        text=f"{RESULTS}/claims.md",
    log:
        f"{RESULTS}/logs/claims.log",
    benchmark:
        f"{RESULTS}/benchmarks/claims.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        study=STUDY.name,
        method=STUDY.method.value,
        names=dict(STUDY.claims or {}),
        study_parts=STUDY_PARTS,
        code=STUDY_CODE,
    message:
        "judging the paper's statements"
    script:
        "../scripts/claims.py"


rule summary:
    input:
        **TABLES,
    output:
        f"{RESULTS}/summary.txt",
    log:
        f"{RESULTS}/logs/summary.log",
    benchmark:
        f"{RESULTS}/benchmarks/summary.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        strict=STUDY.strict,
        study_parts=STUDY_PARTS,
        code=STUDY_CODE,
    message:
        "counting rows by status"
    script:
        "../scripts/summary.py"


rule report:
    input:
        **TABLES,
        pictures=expand(f"{RESULTS}/figures/{{figure}}.png", figure=STUDY.figures),
    output:
        f"{RESULTS}/report.html",
    log:
        f"{RESULTS}/logs/report.log",
    benchmark:
        f"{RESULTS}/benchmarks/report.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        study=STUDY.name,
        title=STUDY.title or figure_name(STUDY.name),
        claims=dict(STUDY.claims or {}),
        figures=FIGURES,
        study_file=(STUDY_FILE.name, STUDY.text),
        study_parts=STUDY_PARTS,
        code=STUDY_CODE,
    message:
        "writing the report"
    script:
        "../scripts/report.py"
