# From the tables to figures, verdicts, summary and report.
TABLES = {name: f"{RESULTS}/tables/{name}.parquet" for name in STUDY.tables}
COMPUTED = {name: path for name, path in TABLES.items() if name != "claims"}
STUDY_PARTS = {name: STUDY.study_part(name) for name in STUDY.tables}
# Inputs of each figure, with its caption.
FIGURES = STUDY.figure_params
SCRIPTED = {name: figure for name, figure in FIGURES.items() if figure["script"]}
PICTURES = expand(f"{RESULTS}/figures/{{figure}}.png", figure=FIGURES)


rule figures:
    input:
        force_outdated("figures/captions.md", *(f"figures/{name}.png" for name in FIGURES)),
        **COMPUTED,
    output:
        report(
            expand(f"{RESULTS}/figures/{{figure}}.png", figure=FIGURES.keys() - SCRIPTED),
            category="Figures",
        ),
        [
            f"{RESULTS}/figures/{name}.{ending}"
            for name in FIGURES.keys() - SCRIPTED
            for ending in FIGURES[name]["formats"]
        ],
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
        figures={name: FIGURES[name] for name in FIGURES if name not in SCRIPTED},
        captions={name: figure["caption"] for name, figure in FIGURES.items()},
        study_parts=STUDY_PARTS,
        mark=MARKS[outdated.CAPTIONS],
        code=DISPLAY_CODE,
    message:
        "drawing the figures"
    script:
        "../scripts/figures.py"


# A job for each figure of the user's own, as such a script may end the job.
for figure in SCRIPTED:

    rule:
        name:
            f"figure_{figure}"
        input:
            force_outdated(f"figures/{figure}.png"),
            **COMPUTED,
            script=local(SCRIPTED[figure]["script"]),
        output:
            report(f"{RESULTS}/figures/{figure}.png", category="Figures"),
            expand(f"{RESULTS}/figures/{figure}.{{ending}}", ending=SCRIPTED[figure]["formats"]),
        log:
            f"{RESULTS}/logs/figures/{figure}.log",
        benchmark:
            f"{RESULTS}/benchmarks/figures/{figure}.tsv"
        localrule: True
        conda:
            "../envs/vibrissa.yaml"
        threads: 1
        params:
            study=STUDY.name,
            figures={figure: SCRIPTED[figure]},
            captions=None,
            study_parts=STUDY_PARTS,
            code=DISPLAY_CODE,
        message:
            f"drawing {figure}"
        script:
            "../scripts/figures.py"


rule claims:
    input:
        force_outdated("tables/claims.parquet"),
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
        code=DISPLAY_CODE,
    message:
        "judging the paper's statements"
    script:
        "../scripts/claims.py"


rule summary:
    input:
        force_outdated("summary.txt"),
        **TABLES,
        pictures=PICTURES,
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
        figures=list(FIGURES),
        study_parts=STUDY_PARTS,
        code=DISPLAY_CODE,
    message:
        "counting rows by status"
    script:
        "../scripts/summary.py"


rule report:
    input:
        force_outdated("report.html"),
        **TABLES,
        pictures=PICTURES,
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
        mark=MARKS[outdated.REPORT],
        code=DISPLAY_CODE,
    message:
        "writing the report"
    script:
        "../scripts/report.py"
