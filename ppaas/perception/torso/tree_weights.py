"""Trees that tell people from what looks like them, fitted by ``python -m benchmarks.people.torso.training``."""

BIAS = -0.0626
"""Log odds without trees."""

SCALE = 0.00237483
"""Value of one unit of the leaves."""

FEATURES = """
4*^dBPzB=zPz4VJ&H+;eQw4+sQw8q=?*dZ=Fah`kFaa3_00lAx@dWS$<OC1_76lUpZ~;;TF9ALUP6R>)?*i}uO9WE|Qw386Qw2^1P6bl|HU$s_JO
!`<PX&<xGzAa=<OEU#lmt-$QUnMEQUyK*4g(hjF#$;ht^yDP5ChNwJq1t&PzBBcQw386HwEzoPX+G+Qw28#@B%jlQ3db;KLrp0E&=-lPz4VI_ykV
`?Ex<VPz28buL5xZP6RIjQ3MYIOauT0t^!O11_e_EQw386Qw2{2PX$i}9R)lE83jWHPy`tTS^@9^BL(pS7zG{$BLy!3QUxvnGzBpQ?g3H-J_S$(P
Xtc^&jLOL?*PvM_XO|)`ULO-&;k4eX96w-Fab~i9R<+=5CAF#Qw386PX$v2PX&(xQ2`JGBLyP`8U-E&4FgUEPz6*3PyulQNd+tg&;e2fPX*8c!vr
t|9tAE0QUxyo@B%jlQU!1Vu>uhV_5|(%Pz479)Bv*pGzCorQUxvnPXtE=HU(1!Qw3866a`QPQUx~!9tE!g90jiekpis*nE^BfPytc}00oc%F9kOR
O#}r6Ed>q(kpoi%O$0OrFa<URFaeMN)B}(J5CfY8umZaTPXf>ZI|Wk(Qw5L$KLtVsO##pWGzC%x?gTmouL2PT5d~8PQw2~0Km|bsRRVAV&;srOv;
+zTtOW1@90mRa9tHaZJOvpA{sgH34+H-M4+8Q5IR#GyPy+h|PXhS_?*gv@sstedZUPPiF#>P`>jIGij{;K#JOxt)t^*GP9|bi9uL95l_XH3F(gGj
_@BvT+Nd;2`PX(+1Qv`7WPz5>#2?aw1&jLLKa04j?7zK|55CaYZtOEc5Pz6i`FagX2@&s@JumLm$PXRUsP69jyumX+%j{%be4+6CWvH{Kj&;c+7o
CG!nQ39_5Q3WgoAq6f49tB4Q_W>FO_W}C^j{*+^4+F0O&H@nvumZ3G8wKtGECT)n4+2vKQw5L#5CJ&_Mg=zo1_e<BumeX03I);w002-0PXurPZUb
-vO$9FnQw386HU&Wi(E>aL5(Q2IZvim^?*Xp??g8@vPXhP^&jIcL?*k?UPXajwGzB*WZ~>734*@p?Qw2~3HU(1zDFr(Pv;^@1a{^5QPy+J-(E+Ui
9tHRWdjz8dGzAd@002`3Jq1t&@B=dhIt48S&;o7(&;o7()B=zJumLm$PysdtZ~{98PX&(vQw2T+Z~~A6Fadx9@BuLej{;EzjslVb2nEUkq6BLKQ3
CM+F#_-ckpV0PPzA69P6Rv!Q2})Xy95sd_5|(%QUy=}R07Wex&-e5Py#mv_5{xYQ3VMFPz2BdCIJZra0566P61K{Z~}V-GzE|W&jL9GA_YGM@c=C
aPXf9G{sj62x&-<J3j+QG90d^r?*vi>@c|YC001Ec83i2$9R(o;Aq5!)`~=VfaRJZ*tO79t#{y6V%>a)8&jL0DO9eXx=meVtvIA`bZ~|}x005-~Q
35Xl5dx6`&;j@aE&^`>asoL8Pz7=V>HsbUy#!DI5d$0r=mAazQUy>1_5@G?O9Ze2F9dD^{RHj-Pywz2t^u(E8U+Of?g2&xu>%+dR{}}}Pz5~&Oaw
gz{Qv*}_ympu_XKVM5dzx*5(Nqc@B)Ga@B;q?3<5X>Z2=Mi5&<a%g9J?ig9Pyb(gKkI5ChTzkpV9OAq6xAeF91aH3by~c>*H^Fa<dTx&$@_c>**9
?*h*P4+1*{4+0VZ4+4+^`~=Ve^#nWxk^&e79t9c&83h;x9tAuF#sv8UQ3VnOPXbQ_@d5w<Py(a`GzE<TssvC0Pz5;!Kn2eMKLtMpu>tP_Qw2K(9|
cea!vq)wJOxk%Py{;#Py;*#0|hw+I0aAvFab{j5CJ&_5CSa)LIpShI|YyePz2Kh#RMS*4gvE4(E<?z69KOR&jKI?J_YXq69V-FE(J#gPz6Z?Z~!j
=Jp~E{ZvrR*6#}FLvH|1(2nB8dZv(XiaRIUezXPQNbOKHS(*e@~lLT%7ss#N6Oakrzt^)W3Yypu15dsbZ76J+ZjsgG$Mg@-mQw7ih3Iz`Xiv$e?9
tF_@?E=mL002+{Qw1Ca9R)W9v;<59Mg=PbF$4+)2nA0C69n-D{samFi~?!`ZUW8%;Q);S&;c+4&;rl`aRH425Cabb4+C!kZvv15PXj6i&jOYM&jK
O^EdvDw9t9f(a{;abkpj~JumMp7Rs<adDg;pkF$7cuN(D~>I|a`H&jI29008a;LIn*1@Bpy_5e4-GuL5rZ^#l(CtOWH0lmzhsF#*m3aRChhO#%%8
%>)JoPz6r{r~{J%3I%fk4FT=|tpqUv3IY=aj{+YB9|a)=9R)A}u>t!8_XP9=^aT3^IR*IykODph4FWp_GX!k`_XI8lj{@%mkOCkDXaRl%`~>y{`v
mX+{RA%o_5=(Cuma5k@&OkG@&Nz<Jq1JsJOwxfCIvwSaRMv_F#}Hn69O&-gaq;gF9L4?a{}}P5&?4p8wE`Q4FWL&YynaQaRF}v90mCV83j89=mEU
}oCNIw%>obuQ3B5b%>oqzJOwZTQ38(wIt8%-Q36o~kN{8w5d~5OO9VCrEd^8rkOR>IZ~~A3@Bq*Pj{^DxoCNOy)B;ZgJOwQR83nooF9U4?)&VgEG
z3osD+NykQUK@z!UO;X!UV4Z1p^TSF#`4kJ_S$(Oa(jzK?MK+3I$69F9S;iQUosnIt4BQt^v*g&H*X`&H?xY?f@|X5dm%ig9Oe1lL3+f&jL&W&;m
~ZQ33A&umbP`83nxrMg<uKvI3<9v;l4cgam{HkODCQ3<Yfh?E~!rZ31uu003|Sbpfvds{t7W>H+fvQ3a0!PXrGG)C4sIPXMX}{sd40O#y8JZ~@Q(
>I5AH%>(WM5(5ALZvl`3&;if^q6Cit&;hdqZ~>J8Py(_9?*SA8I0aAzNCmY7Q3I0%>;TpRMFo%nP6AK@Py&ttAq6o7O$7=CO$E~fD+Q1MvIL0&^#
q3k{RE5x1p^@kbO9R!bpi<jn*;y=QU#6zuLAr8QUbvQ9s>RZMg?sGr~<MC$N^*l9|ai&83m349|ds&9tBDT4*_TcQUy{4cLD$aQU&k?QUx~!a053
5QUxyp^#M`^PXVw2PXW>bJp~W}`UDgOPyzS^tN~F1(E-r`rUVcH(E%F;kOGndjRFz_P684G&jFDFkpjR35dzTxZ31Zl2?bFFECnnDQv~D$ume#7(
gDu`u>vs!?*VWDQUwzQ@B(rJj{_|Q90gGYssynDR047Wa{@8~j{&a%asl)NPXaOm%K=6Oj{@xjPXSK>kO4LYJOz^kJO!@;I|V%j5CQlE?gWSeu>$
%8Vgd*QF9A>iF99(G@&iu-jsflh4*~iFZvZj@F#(SP00lq=C<GG)4FygCN(3zejRH{ug9Oe3P60p#O$E&XM*}SaE(GobDFti-YXK|*vIO!0uL5xb
Jq0%fHw91uZUF8BHwAJ6tpsuc9|ai&(E{!QBLx5jI0R7z_ykb_H3V$}ssuX)Z2}Df@BwcEQ3a3z!vt^v90d;pN(He3@c|nJ(E?5a7zG>!5CRecr3
8`!4g%=`ssb_vNd-FvN(IvdHU&=wIR!ff4+G8u4+F^oF#%BpFa!Mr5Cd=lR0JReE(PrYHwA10@B-HaF9mM`kpb=js{zpgHw8}uwFI>Uk^&<Ik^&k
9lmblx%>fbtF#$0FE&(<LhysWLPXaduX#oua&jIZLtpX4O=>gCJtpX4NAq5HrvjR^9PyrhSrUWhpbOA90^a1n%3I%llOa&AI)&x`nP6WjRzXVPMQ
v_24Qv^-~Sp+Zw9|a%<9R>9SMFdd=vjIH?Fak~j6azE@?g35$Hw6F%F9C1@`~+_TF9D+jx&)g9%mNPsn*=ZdJq3>f5e2&h(gMx`u>rRNwggcE90g
JWQUV$U5CRwl4FL=SK?S=6X#!9MI0Q!oM+I;KlK{yA>I4h|?gO&~4g>%IGz7#14+Am;&jPOk9tBYZ&jJquA_Z&$>;W1D_5l+Da{_Y$a{|!<9tF<=
Aq9;AUI7jQ@c?K6l>!O{Mg`6RkOCD2002=0`~(06`ULd^1_kv5tO4}|u>wK_u>u?gKm`B*YyzwSFaoOqDgn>}QU&h;Q3VtN4g$9V#RM4z>;a1eE&
*%;G68V{G6C)a?E!59tpWW6V+1h)`~>#|4g>WB`~(gI4Fk^tj{+P8j0B7XZ~~74jsgq<aRT@Rt^x4`Qvy*1BLyx5wFIyNR0Jah2?b6BPy=oQP6R3
hJp~d1(gD%|asm|rQUV$ULIpVmkphDR8U?WdQUOv0G6l5+001%twFDgn69Ur#4*?JXbO9IzZ2?mS8U=#{PXkf~j{#Bz3Ij3%_5>0GF9H$+iUKGFP
XPb`aRDy@000009|af%aRDC%9|af%@c~l>DFuiGEd`JOQU&V)N(IUUmjjCgas$x-iUSM+jREihq6CWs5Ce_@?*i`vj{=VZ90gDXiUNoN2m+%7hyr
T?Z34^z
"""
"""Feature of each decision, uint16, little-endian, as base85."""

LIMITS = """
2nYiJ0|*QX2m%HP2@DAW4gvxW0ssIA00IaP2?Y-X2@Vem2n+@S0ssO41qcEV1_%HT0|){F4+9AS2?7ZT1qlKI0tg8P0ssOD3jzrR1PKKS2?+uU2?
h%Z00{^Y5DO0q4+RVa0tp8U1p)#B3IYlP5C9Mf1q=lR2?`Gh1^@{X6aotg2?YrW3JD4Y2m%2B2@nbk0RamK0tEsH015>H1qBQV0ssgI0s{yV0s#&
I0TB-h2m}NO3j_)c0s#pL1`Y@a3kU=V1q}cJ3<3!V2?hug4hIPc2MGrR4g>-S5f2dt00asU000UR3=szk3=0Ja0t^5M2MhxO2m}HN1qK2M3<wDd6
aWqh1_uZR3<nAi2n7fX1`G%a2nq-Y5eo<i2nP-b3<m)a5DEnY4GIDZ4Fd`c2@e4b1PTHK1Oo;F3<L@e2nrD&0uKon0SO5O00IaB3IGQO2L}KE2ml
cV2nh@U2LJ~G1qTlb2nY!X3JMJh0SX5J3JU}W0SE&E1Pl%W0udhq3jh!b1ON>L0tN&P00;;O2nYxO1_A~R000OD0|EsA3k41V0uTWW7YPan2nq=Y
3=9<!1O*=k0s#;a1O*2N2m=QQ2n7HF2m%BE2m%HS3jhWH4HO6o0RkQg2?+=a2?PTS3jqlL6$%Cm5(*6m1_uWK016QV0T2KJ4g>%Q2m$~H5Cs7V3j
quq1qKEL4+0Db01pTO9|Z*j1_1~J3lItl3<?GT01yWP2L}KV5C{nXA07w^2nYuS2nYxV0|Ed58V(5u1q2fe000jN5eNeb00{^P3j+!P4+{ng0TB=
Z1s@Cu3<wAT00#~P3IGEN2N4bc7X}##3JC}e1quoR5eEVR2?ziV8U_y!4+;wn3IPrc1PTNM2ml2I1O)*B0}K=Z2mt^e1_c5J5C8@R0SE*O2nYlN1
PKQO1Of{K5d{DX1po&K01pNS0t5mE2LS{F4iO3m4h;$e4GIMY00IRO01yWU2mlWb3;_fO3kL@d5FQB$2?-4e2>}KT2LlHP2nZ1X0|o>D3km=Q0RR
gC4GA9y5DWwa5Df(p5di@L5CIAg2n+@a00;;O2nYxc4+;(n3IY%V5D^Lj4*&!N1_%rc2n-Pe5dskp3I`Af2m>Dj0R|2P0tF2S0tgNO3knGd3JwPV
9s>gg5e@(b5ex|q5dseb0|NsG2n7WM1pxpB2n`4X4+sDN5C8}R5DNnX0}25F0ssvV3<3ck0s{mB00amG5fBUl1Of;N2m$~C0tg5Q1`P-d3=9ek1_
TWZ3JM1d3=jbT1_%WP2onGS01p8I01gic2@e1e2n7)c3=IJR4FU}Y3IGuS0uTTI1p^HU1_=WV2LS~K5gz~!4h0Jj4+see2>=5K3lI+p6%Y>y2M7Z
U5C;tq0to{E3>OUw8UY9g00s^Q2ml`k5C{<g5d;$m0T3Ak0SW>L4F?Da00jUG4Ic*x2?!Se0}cle2L}TH1OWmF3Ih=e1PK8N2mt{A2mk^P0T2`h2
nGfQ01F2Y1`!n>69@<c2m%QU1P2ib1rY-S0tf*J0}2lj2M-J%1ONvE0RRdJ5DEYX2nYrW1OW*I4+see9smUh3<?Pf2M!7j2nz@Z2?hfc000313;_
`b0|^KT1ON{N0S5sB0|5pA5C{hd2LT8N5d;bV00;>K0RRLD1q2Zc0|pHP0|*BI2@wDX3J(zi5eo?i2mucP00s^S2nZMq5C#Yg5C{+f0tyET2@41b
2m=BD000OE2L}QI2MP!Z5fupr3<d`T0s{vK0tgEL1quQU2?GfS0Rs#O0tg5S1_1{L0uuuV5Df_l3<dxX4gn7c0RaRI2nq@k1`P)c5C;Ve7YYUg1_
BBO1`ZGa5CRSc2nhxT2nz}d5ey3o3kL`R01F)e1_1;C0RadP6AA|o77P&&4g(Jc0|Ns900R#K2nG=W1_%TN2M7fR3Jw<z2n-Df0SE&L1qTKZ2nYo
U1_KQZ00<8Z0Ra&a0tf&P01N;Y5FZN*3IPfV0}Bug0SEvF1qcWT1qlKO3kMGg3lRth00s*H9}WWp0|NmA4-F3j2m%iu2nh%W00;^T0tyHW1py5i5
DE_p4-X6s3<Dks0|N~M0SgNc5C#Yh2nqoa0R;g92oDMY6bS(W0|gBb3lItj2?z)P5eNbS1_uQO5d;7f9|Hyk4Gjqo00RdK03Hnw2MiGi2?z)g2?h
Wk3;`b>1_lWO0tE;X0096E3<d@s5gQQ*2nYuV3I_-R4+;wk0t68b1`Y-W1_=
"""
"""Limit of each decision, uint8 as base85."""

LEAVES = """
;-KYIBBFKAmaWYf2uwk7uGI|FSM|eQ;}O3#$|Fqaw9w-gL)s6ptHRnN2uw6r=@75y%_u|P;R?(E5JAR9zV8k}%JVVayAa9s5Jbu%y{^so0y!&9{M
9Pu_C47O@)`QH47)}A^cLS2E!ndO0@*O#&?%`YywcnX|1c>^z5EE+!5y#{_!=9`C$!u-2hKhA{m`%)_ZZT#_CQ1X2=X-e%q%Li{=Xg7)vw(*#oX`
~4KW=@`W6+?6xc=K`4rhC3)DRe0mdQP+)T_a2ji+Q)(9Nf{Sr&Wt<Ba;0UP|$KI^B}*1y^I8vPqV3i19ZBFw=V0MRGvH`%Jw{t~w}>#o*H02ssQ>
#fQG{U{gQDe&}%yx9ET|0GHe)D-g!4#nKFyxaQZBw73y`W4n8D*N+@0URUOR`=CW0^R_|D(&J9^$;ldA;`Jm3+^86^(;lx!|vq*2=XF9{2eL!%qf
%<{}H)4<|(`t@)85)&l=KC{td$Ywfa#20LJCD_)9nY^9scgu=3Fa@eBbhNdo`u{S@XV>%#0H0U*!%1y$BS_!=Vh;5@YR0_X!V-8iNs?act{5Ig)K
0UOySxe`tQ|H#E04AeC3%kK#J04y6j>=q>QBlJoW3&v6rEz<M`10los_q-?V{KXFE{x3TA`3@`y9ojhk1oXiJ*tHS>$`J4s4fhk}3NZR1<ro(3^a
;}tvkBS(&J^|#HVZ8N{R;1-<Po^%0`CPX<R3)v|J2MB$|~(u{VpNU>@SJs75P5;_(Jjy1J1${x<K$J_X;=y!bKD60UZC`yBtdF{}WN}3G9dB1MVX
A-Lwk;{zv~nS?xaR{}kx2!uaDd3;EFi2+2+e{0;0P?y>v;`ye3s9^^s){ow*77x6y`0TuY2!~o+Y{R|1iBhbxD`ws3pB?Ras{07E3_`B0T{?643s
{kSZ_zwRrFXg@y{}9F$0=O^O1mG{aCHniV`wcVn_dVVg1iZcdy9XQA1oz(s#syx^{ShDP!xLoS{~|&5>#5aC{yOqc$5!P3{s_eV<Fx_+<O>fz{1f
LE&L0CD5%mAx#SG*R03A8^0L%5l`ok3Q_Xsrw8_gZ&%=!`l4Zl;}1MBKI90C)x{SYGN;I1d00L;oH$?eh?0`B}Cw)8yS`3(y8$RRxX{1O@f_}o9;
3EANI1U?J-{pTO}8uu~J_7em$8T>8?0`$rMB>?QL0rc9cJN))B0Ok2W1G`TU02vka<Vdv*`6LYG^&~p~{u&?V@;b8!01nA7$}Cp+`U*3m26g`4{}
k~i@gW4n{Wt~ou=gPV`MV4MC(q3Q`49UW*B|?*{WT-)-~(CX3;)I<z%cJU`3)||0_x8P0!S|T+?OiY{V?-S2RAF}2KE%w`XkjQ{RXrM$NAwC`y2m
MSqdcg0`&c~?XevI#S9L-`7-+k1NgcP%LQBn0`XD)3Gx9h0q!ma`yVUG{|me2%{J<~2>Tes0^B&$7w5?n03Y}T0puI*y7cE0{SDC<06Xzy0PP+8=
&=*P*%-|p2miqa0p}mb54$Ar{SDtD2O<*o{>>%;)fBk^|0VRg0ZnKB`a5C&_%{8){tzX?@gB1D`yKWy`zs^o{sq7M(<Ah$0oOAD?E*UU03P)N|FR
nZ{ucu|3F`ad0N5S*!4VDT1L4~L_Y*Jy1MB>(769tC0P%ka=PL6F`3dhSD*XQM{><Py_#+?&{T~Y45k?RF01n0t-y-lm{SX}h5%@5Z{|f=>#|bF_
1oi(M<sHcz0rdL|*f_!e`3eC>MEXAXDF6<{u<;xKwDwx$-Z%3B{0t20{LKO$``|1D1Ty+i0P9iu@-zRz{Sf;W8PK0Q`wt!c>ai~901wgq-#XVY3N
YC){1W&Uvg$wD0o4b{3)I#N5AOQ}{vA9D{Sy4+_5~>91u5zY9N^D00z&}h0r3vp>$4ca{!%Ig3)~Fm0T&C@^hP4S-W37R&=gtF{nr`U{v-D${|EC
l#|A|6{0sQgJpTMK`wim*1kfP)1L62O3fBD=0q+IE&J|tq1nBrH_!9I4@*(ZK01@dE|03xJ>?Q-A{15;n@HW2k02jLh{Ll6z{Rk4h-VCY~0p2<c?
+^^z{|fOS!}lBM02LSezx_Av0qZLU^+DqO{UAC7{T<2s0pKeE8So+c0`nHP1nDuv{sqGc5!kr<{|Ybqy#x>F{|xpOy8$ZR0N?y6^(yzd_XSfARSo
zz@DuOE0vq}S{|Gto{W0PP{S@=K3pw}|;xWbY1pX=H0q+p_73%yI{sh1C8_eUb{w2@)_YWfk0@n68900ij{uU(f^}Q1C{sb7%#|%RJ0P-F4`X&4g
2KE2w#S0|n{2B%OA^^k~{}M&x2~zkr{|5TO$^@_g|L!yY`V!h3?gs??)ez@V01WJ;@iQpd0VMJ_)G+%z{V)AG{3i*${sr!;@xtUa4Ds6w4C(j*1p
Mx{zWN2{0OuC@+Z0g-`V2w=Gw}em+OGuT03H4lz5pN4{|Nrz0qax&@jy8B^e_tl1^NNA`40aR4c_3J{x=u?!T<mO1Nrkt6YW3c{|f0R8|)Z60p|(
B#QyR*{SoT|`xE#e{}U+q#{lv^{~;d)4(b{G
"""
"""Leaves, int8 as base85."""
