CREATE TABLE public.alembic_version (
    version_num character varying(32) NOT NULL
);
CREATE TABLE public.attempts (
    id bigint NOT NULL,
    job_id character varying(32) NOT NULL,
    generation integer NOT NULL,
    particle integer NOT NULL,
    number integer NOT NULL,
    worker character varying(80),
    started_at double precision,
    finished_at double precision NOT NULL,
    outcome character varying(32) NOT NULL,
    message text
);
CREATE SEQUENCE public.attempts_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.attempts_id_seq OWNED BY public.attempts.id;
CREATE TABLE public.evaluations (
    job_id character varying(32) NOT NULL,
    generation integer NOT NULL,
    particle integer NOT NULL,
    state character varying(16) NOT NULL,
    parameters bytea NOT NULL,
    objective double precision,
    misfits text,
    responses bytea,
    reason character varying(32),
    message text,
    attempts integer NOT NULL,
    worker character varying(80),
    lease_expires_at double precision,
    started_at double precision,
    finished_at double precision,
    seconds double precision
);
CREATE TABLE public.events (
    id bigint NOT NULL,
    job_id character varying(32) NOT NULL,
    kind character varying(32) NOT NULL,
    data text NOT NULL,
    created_at double precision NOT NULL
);
CREATE SEQUENCE public.events_id_seq
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.events_id_seq OWNED BY public.events.id;
CREATE TABLE public.generations (
    job_id character varying(32) NOT NULL,
    number integer NOT NULL,
    evaluations bigint NOT NULL,
    failed bigint NOT NULL,
    best_objective double precision,
    objective double precision,
    parameters text,
    created_at double precision NOT NULL,
    finished_at double precision NOT NULL
);
CREATE TABLE public.jobs (
    id character varying(32) NOT NULL,
    name text NOT NULL,
    state character varying(16) NOT NULL,
    forward_model text NOT NULL,
    method text NOT NULL,
    problem text NOT NULL,
    seed bigint NOT NULL,
    free_parameters text NOT NULL,
    grids text NOT NULL,
    max_evaluations bigint,
    idempotency_key text,
    body_hash character varying(64) NOT NULL,
    generation integer NOT NULL,
    progress text,
    dispatched_at double precision,
    generations integer NOT NULL,
    evaluations bigint NOT NULL,
    failed_evaluations bigint NOT NULL,
    failures text NOT NULL,
    objective double precision,
    parameters text,
    best_generation integer,
    best_particle integer,
    stop_reasons text NOT NULL,
    error text,
    created_at double precision NOT NULL,
    started_at double precision,
    finished_at double precision,
    run_seconds double precision NOT NULL,
    clock_at double precision,
    typical_seconds double precision,
    served_at double precision,
    rung_at double precision
);
CREATE TABLE public.workers (
    id character varying(80) NOT NULL,
    host text NOT NULL,
    pid integer NOT NULL,
    machine text NOT NULL,
    engine character varying(16) NOT NULL,
    started_at double precision NOT NULL,
    seen_at double precision NOT NULL,
    lost_at double precision
);
ALTER TABLE ONLY public.attempts ALTER COLUMN id SET DEFAULT nextval('public.attempts_id_seq'::regclass);
ALTER TABLE ONLY public.events ALTER COLUMN id SET DEFAULT nextval('public.events_id_seq'::regclass);
INSERT INTO public.alembic_version VALUES ('0001');
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 0, 0, 'finished', '\x2c42d80f4a43f1bf200a675ef592e33f', 13.30668259580615, '{"y":13.30668259580615}', '\x007b2279223a337d0a2c42d80f4a43f1bf70f492823de7ddbfa03f76745a7dc23f', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5610263, 1795239009.5611885, 8.480600081384182e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 0, 1, 'finished', '\x101082a62ad50d4052ab5e164dc0f43f', 4.4343337700558685, '{"y":4.4343337700558685}', '\x007b2279223a337d0a101082a62ad50d40dcb2d898a81a1440b15d70debb4a1940', NULL, NULL, 1, 'worker-1', NULL, 1795239009.564767, 1795239009.564856, 4.339499992056517e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 0, 2, 'finished', '\xd2543fe6b26efebf1443f9b8663de03f', 20.796947946592088, '{"y":20.796947946592088}', '\x007b2279223a337d0ad2543fe6b26efebf48b3c289ff4ff6bf7c238c5a9862ecbf', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5670695, 1795239009.5671434, 3.5181999919586815e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 0, 3, 'finished', '\x4eb3ba6c8aba1140e1b082fd299d0540', 17.41749587243019, '{"y":17.41749587243019}', '\x007b2279223a337d0a4eb3ba6c8aba1140be0b7c6b1f891c4018b21e35daab2340', NULL, NULL, 1, 'worker-1', NULL, 1795239009.568878, 1795239009.5689538, 3.793599989876384e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 1, 0, 'finished', '\xeade13f85a5e0f4090702a60c386e43f', 3.671914337967927, '{"y":3.671914337967927}', '\x007b2279223a337d0aeade13f85a5e0f40873d0fe805401240998b1454ded01440', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5705714, 1795239009.5706642, 4.6799000301689375e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 1, 1, 'finished', '\xe826559af224ee3fa27dc1ddbc1fed3f', 2.1094814351302325, '{"y":2.1094814351302325}', '\x007b2279223a337d0ae826559af224ee3f45520bbc57a2fd3f8b0876151b190640', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5762057, 1795239009.5762742, 3.4050000067509245e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 1, 2, 'finished', '\x9755e08ca6c80840db37b93bc77afb3f', 3.3490688834352462, '{"y":3.3490688834352462}', '\x007b2279223a337d0a9755e08ca6c80840c2785e1505431340b9c64ce4b6211a40', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5779366, 1795239009.5780008, 3.1196000236377586e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 1, 3, 'finished', '\xe0129fd6889d0b407827474c9c2ef73f', 3.8155324127018253, '{"y":3.8155324127018253}', '\x007b2279223a337d0ae0129fd6889d0b404e53617e6b9a13402c1d739112661940', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5794446, 1795239009.5795083, 3.076499979215441e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 2, 0, 'finished', '\xf09ce7e6f0db0a40622d3de803d0f03f', 2.5836382059982204, '{"y":2.5836382059982204}', '\x007b2279223a337d0af09ce7e6f0db0a40d019836df9a1114029659267fad51540', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5810187, 1795239009.581092, 3.5884000681107864e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 2, 1, 'finished', '\x8c58a6f95179f1bfedead431f616e43f', 13.256770269283768, '{"y":13.256770269283768}', '\x007b2279223a337d0a8c58a6f95179f1bf568cef825bb7ddbf089374c121edc43f', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5848353, 1795239009.5848987, 3.0205000257410575e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 2, 2, 'finished', '\x3f70bea21d8e1140e2250f548fc7fc3f', 10.187200856857737, '{"y":10.187200856857737}', '\x007b2279223a337d0a3f70bea21d8e1140b839c27701c018403003c64ce5f11f40', NULL, NULL, 1, 'worker-1', NULL, 1795239009.586275, 1795239009.5863369, 3.0094999601715244e-05);
INSERT INTO public.evaluations VALUES ('7284e51e395e9aab', 2, 3, 'finished', '\x4cbddb269ab9ed3fc0f4de0b7a57c03f', 6.1139772934413825, '{"y":6.1139772934413825}', '\x007b2279223a337d0a4cbddb269ab9ed3f3ebde954bce7f03fd69b6596abf2f23f', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5876293, 1795239009.5876894, 2.9243999961181544e-05);
INSERT INTO public.evaluations VALUES ('6387740ff9f48eb0', 0, 0, 'finished', '\x2c42d80f4a43f1bf200a675ef592e33f', 13.30668259580615, '{"y":13.30668259580615}', '\x007b2279223a337d0a2c42d80f4a43f1bf70f492823de7ddbfa03f76745a7dc23f', NULL, NULL, 1, 'worker-1', NULL, 1795239009.5996072, 1795239009.599723, 5.8988000091630965e-05);
INSERT INTO public.evaluations VALUES ('6387740ff9f48eb0', 0, 1, 'finished', '\x101082a62ad50d4052ab5e164dc0f43f', 4.4343337700558685, '{"y":4.4343337700558685}', '\x007b2279223a337d0a101082a62ad50d40dcb2d898a81a1440b15d70debb4a1940', NULL, NULL, 1, 'worker-1', NULL, 1795239009.6013415, 1795239009.601419, 3.8887999835424125e-05);
INSERT INTO public.evaluations VALUES ('6387740ff9f48eb0', 0, 2, 'finished', '\xd2543fe6b26efebf1443f9b8663de03f', 20.796947946592088, '{"y":20.796947946592088}', '\x007b2279223a337d0ad2543fe6b26efebf48b3c289ff4ff6bf7c238c5a9862ecbf', NULL, NULL, 1, 'worker-1', NULL, 1795239009.6027656, 1795239009.6028395, 3.7356000575528014e-05);
INSERT INTO public.evaluations VALUES ('6387740ff9f48eb0', 0, 3, 'finished', '\x4eb3ba6c8aba1140e1b082fd299d0540', 17.41749587243019, '{"y":17.41749587243019}', '\x007b2279223a337d0a4eb3ba6c8aba1140be0b7c6b1f891c4018b21e35daab2340', NULL, NULL, 1, 'worker-1', NULL, 1795239009.6041632, 1795239009.604231, 3.437099985603709e-05);
INSERT INTO public.evaluations VALUES ('6387740ff9f48eb0', 1, 2, 'pending', '\x9755e08ca6c80840db37b93bc77afb3f', NULL, NULL, NULL, NULL, NULL, 0, NULL, NULL, NULL, NULL, NULL);
INSERT INTO public.evaluations VALUES ('6387740ff9f48eb0', 1, 3, 'pending', '\xe0129fd6889d0b407827474c9c2ef73f', NULL, NULL, NULL, NULL, NULL, 0, NULL, NULL, NULL, NULL, NULL);
INSERT INTO public.evaluations VALUES ('6387740ff9f48eb0', 1, 0, 'finished', '\xeade13f85a5e0f4090702a60c386e43f', 3.671914337967927, '{"y":3.671914337967927}', '\x007b2279223a337d0aeade13f85a5e0f40873d0fe805401240998b1454ded01440', NULL, NULL, 1, 'worker-1', NULL, 1795239009.6055126, 1795239009.605589, 3.7955999687255826e-05);
INSERT INTO public.evaluations VALUES ('6387740ff9f48eb0', 1, 1, 'running', '\xe826559af224ee3fa27dc1ddbc1fed3f', NULL, NULL, NULL, NULL, NULL, 1, 'worker-1', 1795239024.609022, 1795239009.609022, NULL, NULL);
INSERT INTO public.events VALUES (1, '7284e51e395e9aab', 'state', '{"state":"queued","stop_reasons":[],"error":null}', 1795239009.549045);
INSERT INTO public.events VALUES (2, '7284e51e395e9aab', 'state', '{"state":"running","stop_reasons":[],"error":null}', 1795239009.557031);
INSERT INTO public.events VALUES (3, '7284e51e395e9aab', 'generation', '{"number":0,"evaluations":4,"failed":0,"best_objective":4.4343337700558685,"objective":4.4343337700558685,"parameters":{"a":3.7290852554742813,"b":1.2969485162563683}}', 1795239009.570568);
INSERT INTO public.events VALUES (4, '7284e51e395e9aab', 'generation', '{"number":1,"evaluations":8,"failed":0,"best_objective":2.1094814351302325,"objective":2.1094814351302325,"parameters":{"a":0.9420102133092003,"b":0.9101242381256507}}', 1795239009.581016);
INSERT INTO public.events VALUES (5, '7284e51e395e9aab', 'generation', '{"number":2,"evaluations":12,"failed":0,"best_objective":2.5836382059982204,"objective":2.1094814351302325,"parameters":{"a":0.9420102133092003,"b":0.9101242381256507}}', 1795239009.589009);
INSERT INTO public.events VALUES (6, '7284e51e395e9aab', 'state', '{"state":"finished","stop_reasons":["max_evaluations"],"error":null}', 1795239009.589009);
INSERT INTO public.events VALUES (7, '6387740ff9f48eb0', 'state', '{"state":"queued","stop_reasons":[],"error":null}', 1795239009.595037);
INSERT INTO public.events VALUES (8, '6387740ff9f48eb0', 'state', '{"state":"running","stop_reasons":[],"error":null}', 1795239009.597832);
INSERT INTO public.events VALUES (9, '6387740ff9f48eb0', 'generation', '{"number":0,"evaluations":4,"failed":0,"best_objective":4.4343337700558685,"objective":4.4343337700558685,"parameters":{"a":3.7290852554742813,"b":1.2969485162563683}}', 1795239009.60551);
INSERT INTO public.events VALUES (10, 'f143306f4d7af6a3', 'state', '{"state":"queued","stop_reasons":[],"error":null}', 1795239009.613218);
INSERT INTO public.generations VALUES ('7284e51e395e9aab', 0, 4, 0, 4.4343337700558685, 4.4343337700558685, '{"a":3.7290852554742813,"b":1.2969485162563683}', 1795239009.557031, 1795239009.570568);
INSERT INTO public.generations VALUES ('7284e51e395e9aab', 1, 8, 0, 2.1094814351302325, 2.1094814351302325, '{"a":0.9420102133092003,"b":0.9101242381256507}', 1795239009.570568, 1795239009.581016);
INSERT INTO public.generations VALUES ('7284e51e395e9aab', 2, 12, 0, 2.5836382059982204, 2.1094814351302325, '{"a":0.9420102133092003,"b":0.9101242381256507}', 1795239009.581016, 1795239009.589009);
INSERT INTO public.generations VALUES ('6387740ff9f48eb0', 0, 4, 0, 4.4343337700558685, 4.4343337700558685, '{"a":3.7290852554742813,"b":1.2969485162563683}', 1795239009.597832, 1795239009.60551);
INSERT INTO public.jobs VALUES ('6387740ff9f48eb0', 'half', 'running', 'formula', 'particle_swarm', '{"name":"half","forward_model":{"kind":"formula","series":{"y":{"expression":"a + b * x","x_unit":"dimensionless","y_unit":"dimensionless","x_lower":null,"x_upper":null,"description":""}}},"parameters":{"a":{"lower":-5.0,"upper":5.0,"scale":"linear"},"b":{"lower":0.0,"upper":4.0,"scale":"linear"}},"constraints":[],"observations":[{"series":"y","points":{"x":[0.0,1.0,2.0],"y":[1.0,3.0,5.0]},"weight":1.0}],"method":{"kind":"particle_swarm","particles":4,"form":"constriction","topology":"global","boundary":"reflect","max_velocity":0.5},"stopping":{"max_evaluations":40},"seed":7}', 7, '["a","b"]', '{"y":[0.0,1.0,2.0]}', 40, NULL, '642500d44e6de9bd8afa6206e015b995062a51dda8496cb68e24746491b53e1e', 1, '{"generation":1,"positions":[[3.9210719471992563,0.6414505842435734],[0.9420102133092003,0.9101242381256507],[3.097973919483319,1.7174751599263718],[3.451921154717965,1.4488795261008516]],"evaluations":4,"failed":0,"best":{"objective":4.4343337700558685,"generation":0,"particle":1,"parameters":[3.7290852554742813,1.2969485162563683]},"stagnation":0,"snapshot":{"generation":1,"position":[[3.9210719471992563,0.6414505842435734],[0.9420102133092003,0.9101242381256507],[3.097973919483319,1.7174751599263718],[3.451921154717965,1.4488795261008516]],"velocity":[[5.0,0.02976131767645812],[-2.787075042165081,-0.3868242781307177],[5.0,1.2099798889334077],[-0.9802475186974943,-1.2528607202435915]],"best_position":[[-1.0789280528007437,0.6116892665671152],[3.7290852554742813,1.2969485162563683],[-1.902026080516681,0.5074952709929641],[4.432168673415459,2.701740246344443]],"best_objective":[13.30668259580615,4.4343337700558685,20.796947946592088,17.41749587243019]}}', 1795239009.60551, 1, 4, 0, '{"reasons":{},"first_message":null}', 4.4343337700558685, '{"a":3.7290852554742813,"b":1.2969485162563683}', 0, 1, '[]', NULL, 1795239009.594635, 1795239009.597832, NULL, 0.007678031921386719, 1795239009.60551, 3.812200020547607e-05, 1795239009.6008, NULL);
INSERT INTO public.jobs VALUES ('f143306f4d7af6a3', 'queued', 'queued', 'formula', 'particle_swarm', '{"name":"queued","forward_model":{"kind":"formula","series":{"y":{"expression":"a + b * x","x_unit":"dimensionless","y_unit":"dimensionless","x_lower":null,"x_upper":null,"description":""}}},"parameters":{"a":{"lower":-5.0,"upper":5.0,"scale":"linear"},"b":{"lower":0.0,"upper":4.0,"scale":"linear"}},"constraints":[],"observations":[{"series":"y","points":{"x":[0.0,1.0,2.0],"y":[1.0,3.0,5.0]},"weight":1.0}],"method":{"kind":"particle_swarm","particles":4,"form":"constriction","topology":"global","boundary":"reflect","max_velocity":0.5},"stopping":{"max_evaluations":12},"seed":7}', 7, '["a","b"]', '{"y":[0.0,1.0,2.0]}', 12, NULL, '9fe596076dfa8a25f74f470ca05e4e4f561140efb8081b203465b667a5c91e76', -1, NULL, NULL, 0, 0, 0, '{"reasons":{},"first_message":null}', NULL, NULL, NULL, NULL, '[]', NULL, 1795239009.612705, NULL, NULL, 0, NULL, NULL, NULL, NULL);
INSERT INTO public.jobs VALUES ('7284e51e395e9aab', 'line', 'finished', 'formula', 'particle_swarm', '{"name":"line","forward_model":{"kind":"formula","series":{"y":{"expression":"a + b * x","x_unit":"dimensionless","y_unit":"dimensionless","x_lower":null,"x_upper":null,"description":""}}},"parameters":{"a":{"lower":-5.0,"upper":5.0,"scale":"linear"},"b":{"lower":0.0,"upper":4.0,"scale":"linear"}},"constraints":[],"observations":[{"series":"y","points":{"x":[0.0,1.0,2.0],"y":[1.0,3.0,5.0]},"weight":1.0}],"method":{"kind":"particle_swarm","particles":4,"form":"constriction","topology":"global","boundary":"reflect","max_velocity":0.5},"stopping":{"max_evaluations":12},"seed":7}', 7, '["a","b"]', '{"y":[0.0,1.0,2.0]}', 12, 'first', '3e2f3c4f1dd071f633f53cba018bc31a1bc3b52bf2033c26690c6caba1360792', 3, '{"generation":3,"positions":[[0.8211560591613516,1.152824930724299],[-1.5345071440574731,1.2094962955645634],[0.6681375028533272,1.3529267024056697],[1.11597007222107,1.0234590540504835]],"evaluations":12,"failed":0,"best":{"objective":2.1094814351302325,"generation":1,"particle":1,"parameters":[0.9420102133092003,0.9101242381256507]},"stagnation":1,"snapshot":{"generation":3,"position":[[0.8211560591613516,1.152824930724299],[-1.5345071440574731,1.2094962955645634],[0.6681375028533272,1.3529267024056697],[1.11597007222107,1.0234590540504835]],"velocity":[[-2.5362370186348873,0.10203995454375411],[-0.44238795079490856,0.5816933539298531],[-3.7206474234404667,-0.4457939705413937],[0.18706355910687614,0.8957894756924544]],"best_position":[[3.357393077796239,1.050784976180545],[0.9420102133092003,0.9101242381256507],[3.097973919483319,1.7174751599263718],[3.451921154717965,1.4488795261008516]],"best_objective":[2.5836382059982204,2.1094814351302325,3.3490688834352462,3.8155324127018253]}}', 1795239009.589009, 3, 12, 0, '{"reasons":{},"first_message":null}', 2.1094814351302325, '{"a":0.9420102133092003,"b":0.9101242381256507}', 1, 1, '["max_evaluations"]', NULL, 1795239009.547737, 1795239009.557031, 1795239009.589009, 0.03197813034057617, NULL, 3.014999992956291e-05, 1795239009.563856, NULL);
INSERT INTO public.workers VALUES ('worker-1', 'host', 1, '', 'embedded', 1795239009.552384, 1795239009.552387, NULL);
SELECT pg_catalog.setval('public.attempts_id_seq', 1, false);
SELECT pg_catalog.setval('public.events_id_seq', 10, true);
ALTER TABLE ONLY public.alembic_version
    ADD CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num);
ALTER TABLE ONLY public.attempts
    ADD CONSTRAINT pk_attempts PRIMARY KEY (id);
ALTER TABLE ONLY public.evaluations
    ADD CONSTRAINT pk_evaluations PRIMARY KEY (job_id, generation, particle);
ALTER TABLE ONLY public.events
    ADD CONSTRAINT pk_events PRIMARY KEY (id);
ALTER TABLE ONLY public.generations
    ADD CONSTRAINT pk_generations PRIMARY KEY (job_id, number);
ALTER TABLE ONLY public.jobs
    ADD CONSTRAINT pk_jobs PRIMARY KEY (id);
ALTER TABLE ONLY public.workers
    ADD CONSTRAINT pk_workers PRIMARY KEY (id);
ALTER TABLE ONLY public.jobs
    ADD CONSTRAINT uq_jobs_idempotency_key UNIQUE (idempotency_key);
CREATE INDEX ix_attempts_evaluation ON public.attempts USING btree (job_id, generation, particle);
CREATE INDEX ix_evaluations_running ON public.evaluations USING btree (lease_expires_at) WHERE ((state)::text = 'running'::text);
CREATE INDEX ix_events_job_id_id ON public.events USING btree (job_id, id);
CREATE INDEX ix_jobs_created_at_id ON public.jobs USING btree (created_at, id);
CREATE INDEX ix_jobs_state_served_at ON public.jobs USING btree (state, served_at);
ALTER TABLE ONLY public.attempts
    ADD CONSTRAINT fk_attempts_job_id_jobs FOREIGN KEY (job_id) REFERENCES public.jobs(id) ON DELETE CASCADE;
ALTER TABLE ONLY public.evaluations
    ADD CONSTRAINT fk_evaluations_job_id_jobs FOREIGN KEY (job_id) REFERENCES public.jobs(id) ON DELETE CASCADE;
ALTER TABLE ONLY public.events
    ADD CONSTRAINT fk_events_job_id_jobs FOREIGN KEY (job_id) REFERENCES public.jobs(id) ON DELETE CASCADE;
ALTER TABLE ONLY public.generations
    ADD CONSTRAINT fk_generations_job_id_jobs FOREIGN KEY (job_id) REFERENCES public.jobs(id) ON DELETE CASCADE;
